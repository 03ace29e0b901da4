#include "externals/phantom/motor_heat.hpp"

#include "core/haptic/chain/thermal.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

namespace tactus::phantom {
namespace {

struct Heat {
  double heat_n2 = 0, time_s = 0;
};

struct Store {
  std::mutex mutex; // several instances of the host may have a thread each
  std::map<std::string, Heat> devices;
};

/// Never destroyed, since objects may be deleted at the very end of the program.
Store& store() {
  static auto* const made = new Store;
  return *made;
}

/// An unloaded motor cools exponentially: h' = -h / tau.
double decayed_n2(const Heat& heat, double now_s) noexcept {
  const double passed_s = std::max(now_s - heat.time_s, 0.0);
  return heat.heat_n2 * std::exp(-passed_s / haptic::ThermalLimit::kTimeConstant_s);
}

} // namespace

void store_motor_heat(const std::string& key, double heat_n2, double now_s) {
  const std::scoped_lock lock(store().mutex);
  Heat& heat = store().devices[key];
  heat = {std::max(heat_n2, decayed_n2(heat, now_s)), now_s};
}

double motor_heat_n2(const std::string& key, double now_s) {
  const std::scoped_lock lock(store().mutex);
  const auto found = store().devices.find(key);
  return found != store().devices.end() ? decayed_n2(found->second, now_s) : 0.0;
}

} // namespace tactus::phantom

#include "externals/phantom/force/motor_memory.hpp"

#include "core/dsp/elementary.hpp"
#include "core/haptic/chain/thermal.hpp"

#include "core/dsp/elementary.hpp"
#include <algorithm>
#include <map>
#include <mutex>
#include <set>

namespace tactus::phantom {
namespace {

struct Heat {
  double heat_n2 = 0, time_s = 0;
};

struct Memory {
  std::mutex mutex; // several instances of the host may have a thread each
  std::set<std::string> stopped;
  std::map<std::string, Heat> heat;
};

/// Never destroyed, since objects may be deleted at the very end of the program.
Memory& memory() {
  static auto* const made = new Memory;
  return *made;
}

/// An unloaded motor cools exponentially: h' = -h / tau.
double decayed_n2(const Heat& heat, double now_s) noexcept {
  const double passed_s = std::max(now_s - heat.time_s, 0.0);
  return heat.heat_n2 * math::exp(-passed_s / haptic::ThermalLimit::kTimeConstant_s);
}

} // namespace

std::string name_key(std::string_view name) { return "name " + std::string(name); }

std::string device_key(std::string_view driver, std::string_view serial) {
  return "device " + std::string(driver) + " " + std::string(serial);
}

void latch_estop(const std::string& key) {
  const std::scoped_lock lock(memory().mutex);
  memory().stopped.insert(key);
}

void release_estop(const std::string& key) noexcept {
  const std::scoped_lock lock(memory().mutex);
  memory().stopped.erase(key);
}

bool estop_latched(const std::string& key) {
  const std::scoped_lock lock(memory().mutex);
  return memory().stopped.count(key) > 0;
}

void store_motor_heat(const std::string& key, double heat_n2, double now_s) {
  const std::scoped_lock lock(memory().mutex);
  Heat& heat = memory().heat[key];
  heat = {std::max(heat_n2, decayed_n2(heat, now_s)), now_s};
}

double motor_heat_n2(const std::string& key, double now_s) {
  const std::scoped_lock lock(memory().mutex);
  const auto found = memory().heat.find(key);
  return found != memory().heat.end() ? decayed_n2(found->second, now_s) : 0.0;
}

} // namespace tactus::phantom

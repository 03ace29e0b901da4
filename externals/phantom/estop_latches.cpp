#include "externals/phantom/estop_latches.hpp"

#include <mutex>
#include <set>

namespace tactus::phantom {
namespace {

struct Latches {
  std::mutex mutex; // several instances of the host may have a thread each
  std::set<std::string> keys;
};

/// Never destroyed, since objects may be deleted at the very end of the program.
Latches& latches() {
  static auto* const made = new Latches;
  return *made;
}

} // namespace

std::string name_key(std::string_view name) { return "name " + std::string(name); }

std::string device_key(std::string_view driver, std::string_view serial) {
  return "device " + std::string(driver) + " " + std::string(serial);
}

void latch_estop(const std::string& key) {
  const std::scoped_lock lock(latches().mutex);
  latches().keys.insert(key);
}

void release_estop(const std::string& key) noexcept {
  const std::scoped_lock lock(latches().mutex);
  latches().keys.erase(key);
}

bool estop_latched(const std::string& key) {
  const std::scoped_lock lock(latches().mutex);
  return latches().keys.count(key) > 0;
}

} // namespace tactus::phantom

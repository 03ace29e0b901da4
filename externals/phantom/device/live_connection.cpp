#include "externals/phantom/device/live_connection.hpp"

#include "externals/phantom/device/driver_calls.hpp"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <vector>

namespace tactus::phantom {
namespace {

// The time for which the end of the program waits for devices that do not respond.
constexpr double kExit_s = 0.8;

struct Registry {
  std::mutex mutex;
  std::vector<LiveConnection*> all;
};

/// Never destroyed: it is used while other static objects are destroyed.
Registry& registry() {
  static auto* const made = new Registry;
  return *made;
}

void let_all_go() {
  // Needs no lock: only the host's thread registers objects, and it is ending the process.
  for (LiveConnection* one : registry().all)
    one->let_go();
  static_cast<void>(DriverCalls::join_all(kExit_s));
}

} // namespace

LiveConnection::LiveConnection() {
  static const int registered = std::atexit(&let_all_go);
  static_cast<void>(registered);
  const std::scoped_lock lock(registry().mutex);
  registry().all.push_back(this);
}

LiveConnection::~LiveConnection() {
  const std::scoped_lock lock(registry().mutex);
  std::erase(registry().all, this);
}

} // namespace tactus::phantom

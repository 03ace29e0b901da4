#include "externals/phantom/live_connections.hpp"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <vector>

namespace tactus::phantom {
namespace {

struct Registry {
  std::mutex mutex;
  std::vector<LiveConnection*> all;
};

/// Never destroyed: it is needed while everything else is.
Registry& registry() {
  static auto* const made = new Registry;
  return *made;
}

void let_all_go() {
  // Nobody else registers now: the thread that ends the process is the host's own.
  for (LiveConnection* one : registry().all)
    one->let_go();
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

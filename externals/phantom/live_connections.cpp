#include "externals/phantom/live_connections.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <vector>

#ifndef _WIN32
#include <ctime>
#endif

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

#ifndef _WIN32
/// Nobody waits for this process any more: the servos get 200 ms to write no force, and their
/// drivers 50 ms to send it, then it ends as it would have. Only calls that are safe in a handler;
/// what is shared with the servo has the interrupted thread as its other side, which never goes on.
void on_termination(int number) {
  const timespec tick{0, 1'000'000}, sending{0, 50'000'000};
  for (LiveConnection* one : registry().all)
    one->stop_now();
  for (int waited = 0; waited < 200; ++waited) {
    bool stopped = true;
    for (LiveConnection* one : registry().all)
      stopped = one->stopped() && stopped;
    if (stopped)
      break;
    nanosleep(&tick, nullptr);
  }
  nanosleep(&sending, nullptr);
  std::signal(number, SIG_DFL);
  std::raise(number);
}
#endif

} // namespace

void LiveConnection::guard_termination() noexcept {
#ifndef _WIN32
  struct sigaction now {};
  if (sigaction(SIGTERM, nullptr, &now) == 0 && !(now.sa_flags & SA_SIGINFO) &&
      now.sa_handler == SIG_DFL)
    std::signal(SIGTERM, &on_termination);
#endif
}

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

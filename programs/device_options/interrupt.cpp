#include "programs/device_options/interrupt.hpp"

#include <atomic>
#include <csignal>
#include <cstring>

#include <unistd.h>

namespace tactus::programs {
namespace {

std::atomic<bool> g_stop{false};
static_assert(std::atomic<bool>::is_always_lock_free); // so that signal handlers may use it
const char* g_sentence = "";

// Longest time from an interrupt to the end of the program; the force needs 0.3 s, the device a
// second.
constexpr unsigned kEnd_s = 3;

void leave(int) noexcept {
  static_cast<void>(!write(STDERR_FILENO, g_sentence, std::strlen(g_sentence)));
  _exit(1);
}

} // namespace

bool interrupted() noexcept { return g_stop; }
void interrupt() noexcept { g_stop = true; }
void limit_time_to_end() noexcept { alarm(kEnd_s); }

void listen_for_interrupts(const char* sentence) noexcept {
  g_sentence = sentence;
  struct sigaction action {
  }, last{};
  last.sa_handler = &leave;
  sigaction(SIGALRM, &last, nullptr);
  action.sa_handler = [](int) { // no SA_RESTART, so that an interrupt also ends a question
    if (!g_stop.exchange(true))
      alarm(kEnd_s);
  };
  for (const int one : {SIGINT, SIGTERM, SIGHUP})
    sigaction(one, &action, nullptr);
}

} // namespace tactus::programs

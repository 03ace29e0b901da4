#include "programs/haptic_check/terminal.hpp"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <iostream>

#include <unistd.h>

namespace tactus::haptic_check {
namespace {

std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free);

// From an interrupt to the end of the program: 0.3 s for the force, a second for the device.
constexpr unsigned kEnd_s = 3;

/// A call of a vendor's library may never return, and nothing can end it but the process.
void leave(int) noexcept {
  constexpr char kSentence[] = "\nhaptic_check: a call of the device's driver does not return; the "
                               "program ends without it. Switch the device off and on\n";
  static_cast<void>(!write(STDERR_FILENO, kSentence, sizeof kSentence - 1));
  _exit(1);
}

bool on_terminal() noexcept { return isatty(STDOUT_FILENO) != 0; }

} // namespace

bool interrupted() noexcept { return stop; }

void listen_for_interrupts() noexcept {
  struct sigaction action {
  }, last{};
  last.sa_handler = &leave;
  sigaction(SIGALRM, &last, nullptr);
  action.sa_handler = [](int) { // no restart: a question ends, too
    if (!stop.exchange(true))
      alarm(kEnd_s);
  };
  for (const int one : {SIGINT, SIGTERM, SIGHUP})
    sigaction(one, &action, nullptr);
}

std::string ask(const std::string& question, bool may_ask) {
  if (!may_ask || interrupted())
    return {};
  std::printf("%s ", question.c_str());
  std::fflush(stdout);
  std::string line;
  if (!std::getline(std::cin, line))
    stop = true;
  const auto first = line.find_first_not_of(" \t");
  return first == std::string::npos ? ""
                                    : line.substr(first, line.find_last_not_of(" \t") - first + 1);
}

void LiveLine::show(const std::string& text, double now_s) {
  const bool live = on_terminal();
  if (now_s - last_s_ < (live ? 0.05 : 1.0))
    return;
  last_s_ = now_s;
  shown_ = true;
  std::printf(live ? "\r\033[K%s" : "%s\n", text.c_str());
  std::fflush(stdout);
}

void LiveLine::end() {
  if (shown_ && on_terminal())
    std::printf("\n");
  shown_ = false;
}

} // namespace tactus::haptic_check

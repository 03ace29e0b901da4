#include "programs/haptic_check/terminal.hpp"

#include "core/text.hpp"

#include <cstdio>
#include <iostream>

#include <unistd.h>

namespace tactus::haptic_check {
namespace {

bool on_terminal() noexcept { return isatty(STDOUT_FILENO) != 0; }

} // namespace

std::string ask(const std::string& question, bool may_ask) {
  if (!may_ask || interrupted())
    return {};
  std::printf("%s ", question.c_str());
  std::fflush(stdout);
  std::string line;
  if (!std::getline(std::cin, line))
    programs::interrupt();
  return std::string(trimmed(line));
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

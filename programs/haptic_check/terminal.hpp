#pragma once

#include "programs/device_options/interrupt.hpp"

#include <string>

namespace tactus::haptic_check {

/// After an interrupt everything fades out and stops.
using programs::interrupted;

/// Prints the question and waits for a line; returns the answer without surrounding blanks. Returns
/// empty at once if may_ask is false.
[[nodiscard]] std::string ask(const std::string& question, bool may_ask);

/// On a terminal, each line overwrites the previous one; elsewhere it prints one line per second.
class LiveLine {
public:
  void show(const std::string& text, double now_s);
  void end();

private:
  double last_s_ = -1e9;
  bool shown_ = false;
};

} // namespace tactus::haptic_check

#pragma once

#include <string>

namespace tactus::haptic_check {

/// True after Ctrl-C or a request to end; everything then fades out and stops.
[[nodiscard]] bool interrupted() noexcept;
/// From then on the program ends within 3 s of an interrupt, whatever call does not return.
void listen_for_interrupts() noexcept;

/// Prints the question and waits for a line; the answer without blanks around it. Empty at once
/// when nothing may be asked.
[[nodiscard]] std::string ask(const std::string& question, bool may_ask);

/// Shows a line over the one before on a terminal, and a line a second elsewhere.
class LiveLine {
public:
  void show(const std::string& text, double now_s);
  void end();

private:
  double last_s_ = -1e9;
  bool shown_ = false;
};

} // namespace tactus::haptic_check

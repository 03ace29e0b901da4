#pragma once

namespace tactus::programs {

/// From then on SIGINT, SIGTERM and SIGHUP ask the program to end, and after one of them it ends
/// within 3 s, whatever call of a device's driver does not return: nothing can end that but the
/// process. `sentence` is then its last.
void listen_for_interrupts(const char* sentence) noexcept;
/// True after an interrupt, or interrupt().
[[nodiscard]] bool interrupted() noexcept;
void interrupt() noexcept;
/// The program is about to end: within 3 s.
void limit_time_to_end() noexcept;

} // namespace tactus::programs

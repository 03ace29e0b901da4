#pragma once

namespace tactus::programs {

/// From then on SIGINT, SIGTERM and SIGHUP ask the program to end. It then ends within 3 s even if
/// a call of a device's driver does not return, because only the end of the process can end such a
/// call. In that case it prints `sentence` last.
void listen_for_interrupts(const char* sentence) noexcept;
/// True after an interrupt or after a call of interrupt().
[[nodiscard]] bool interrupted() noexcept;
void interrupt() noexcept;
/// Call it when the program is about to end; it then ends within 3 s.
void limit_time_to_end() noexcept;

} // namespace tactus::programs

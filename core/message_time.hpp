#pragma once

#include <cmath>

namespace tactus {

/// Times in messages are taken modulo 65536 ms: a host's single float then resolves them to 1/256
/// ms, and its text of six digits to 0.1 ms, however long the host has run. The difference of two
/// times is taken modulo the period too, so that they must be less than 32768 ms apart.
inline constexpr double kMessageTimePeriod_ms = 65536;

/// The time in a message, ms: 0 to below 65536, also after rounding to a single float.
[[nodiscard]] inline double message_time(double ms) noexcept {
  constexpr double kHalfStep_ms = 1.0 / 512; // half a step of a single float just below the period
  const double time = ms - kMessageTimePeriod_ms * std::floor(ms / kMessageTimePeriod_ms);
  return time < kMessageTimePeriod_ms - kHalfStep_ms ? time : 0.0;
}

/// Time by which `ms` is later than `before`, ms, -32768 to 32768.
[[nodiscard]] inline double message_time_since(double ms, double before) noexcept {
  const double later = ms - before;
  return later - kMessageTimePeriod_ms * std::floor(later / kMessageTimePeriod_ms + 0.5);
}

} // namespace tactus

#pragma once

#include <chrono>

namespace tactus::net {

/// The monotonic clock, s: that of the servo's heartbeat.
[[nodiscard]] inline double now_s() noexcept {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

} // namespace tactus::net

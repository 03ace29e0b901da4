#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

/// Logical time of audio blocks. Max's scheduler and the sound card have separate clocks. Blocks
/// therefore follow each other exactly, and jump to the scheduler's time if the clocks have drifted
/// apart.
namespace tactus::max {

class BlockClock {
public:
  /// Returns the start of a block of this length, given the scheduler's time.
  [[nodiscard]] double next(double scheduler_ms, double length_ms) noexcept {
    const double tolerance_ms = std::max(kTolerance_ms, 2 * length_ms);
    if (!(std::abs(scheduler_ms - next_ms_) <= tolerance_ms))
      next_ms_ = scheduler_ms;
    const double start_ms = next_ms_;
    next_ms_ += length_ms;
    return start_ms;
  }

private:
  static constexpr double kTolerance_ms = 20;
  double next_ms_ = -std::numeric_limits<double>::infinity();
};

} // namespace tactus::max

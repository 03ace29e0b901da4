#pragma once

#include <cstdint>

namespace tactus::phantom {

/// A grid of times in the host's logical time, one period apart to within rounding, for the servo's
/// ticks or the outputs. The period is `ms` divided by `parts`.
class TickGrid {
public:
  void begin(double now_ms) noexcept {
    origin_ms_ = now_ms;
    count_ = 0;
  }
  /// Returns true, and advances by one, if the next time has come. It advances by one at most, so
  /// that a jump of the host's time causes no burst.
  [[nodiscard]] bool take(double now_ms, double ms, double parts = 1) noexcept {
    if (next(ms, parts) > now_ms + kTolerance_ms)
      return false;
    ++count_;
    return true;
  }
  /// Returns the next time. A grid that is late, after a jump of the host's time or a change of the
  /// period, restarts now.
  [[nodiscard]] double next_ms(double now_ms, double ms, double parts = 1) noexcept {
    if (next(ms, parts) < now_ms - kTolerance_ms) {
      origin_ms_ = now_ms;
      count_ = 1;
    }
    return next(ms, parts);
  }

private:
  // Coinciding times of two grids differ only by rounding.
  static constexpr double kTolerance_ms = 1e-6;
  [[nodiscard]] double next(double ms, double parts) const noexcept {
    return origin_ms_ + static_cast<double>(count_) * ms / parts;
  }
  double origin_ms_ = 0;
  std::uint64_t count_ = 0; ///< times since the origin
};

} // namespace tactus::phantom

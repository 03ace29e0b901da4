#pragma once

#include <cstdint>

namespace tactus::phantom {

/// Times a period apart in the host's logical time, to within rounding: the servo's ticks, or the
/// outputs. The period is `ms` over `parts`.
class TickGrid {
public:
  void begin(double now_ms) noexcept {
    origin_ms_ = now_ms;
    count_ = 0;
  }
  /// Whether the next time has come; it counts then. One at most, so that a jump of the host's time
  /// causes no burst.
  [[nodiscard]] bool take(double now_ms, double ms, double parts = 1) noexcept {
    if (next(ms, parts) > now_ms + kTolerance_ms)
      return false;
    ++count_;
    return true;
  }
  /// The next time. A grid that is late, after a jump of the host's time or a change of the period,
  /// begins again now.
  [[nodiscard]] double next_ms(double now_ms, double ms, double parts = 1) noexcept {
    if (next(ms, parts) < now_ms - kTolerance_ms) {
      origin_ms_ = now_ms;
      count_ = 1;
    }
    return next(ms, parts);
  }

private:
  // Times of two grids that coincide differ by rounding only.
  static constexpr double kTolerance_ms = 1e-6;
  [[nodiscard]] double next(double ms, double parts) const noexcept {
    return origin_ms_ + static_cast<double>(count_) * ms / parts;
  }
  double origin_ms_ = 0;
  std::uint64_t count_ = 0; ///< times since the origin
};

} // namespace tactus::phantom

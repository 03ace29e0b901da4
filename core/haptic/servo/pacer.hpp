#pragma once

#include "core/haptic/device/device.hpp"

namespace tactus::haptic {

/// The time grid of the servo, start + k period. A late wake-up runs one tick and skips the grid
/// points that have passed, so that the phase is kept and ticks never come in bursts.
class Pacer {
public:
  struct Wake {
    Tick tick;
    double lateness_s = 0;
    std::uint64_t skipped = 0;
  };

  void start(double start_s, double period_s) noexcept;
  [[nodiscard]] double deadline_s() const noexcept { return time_of(next_); }
  /// The tick to run at now_s. Call it at or after the deadline.
  Wake wake(double now_s) noexcept;

private:
  [[nodiscard]] double time_of(std::uint64_t index) const noexcept {
    return start_s_ + static_cast<double>(index) * period_s_;
  }
  double start_s_ = 0, period_s_ = 1e-3;
  std::uint64_t next_ = 0;
};

} // namespace tactus::haptic

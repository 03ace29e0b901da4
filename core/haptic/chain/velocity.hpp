#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>

namespace tactus::haptic {

/// Estimates velocity from positions whose error is bounded: first-order adaptive windowing, best
/// fit (Janabi-Sharifi, Hayward & Chen, IEEE Transactions on Control Systems Technology 8, 2000).
/// The velocity is the slope of a least-squares line through the newest samples. The window is the
/// longest, up to 16 intervals, for which the line passes every position within the bound: a slow
/// motion is averaged over many encoder steps, a fast one is followed at once. The actual times are
/// used, so that late ticks do not matter. Each axis has its own window. With a bound of 0 the
/// result is the difference quotient of the last two positions, unless a longer line fits exactly.
class VelocityEstimator {
public:
  static constexpr std::size_t kMaxWindow = 16;

  /// bound_m: the largest error of one position reading, e.g. half an encoder step.
  void set_bound(double bound_m) noexcept { bound_m_ = bound_m; }
  void reset() noexcept { count_ = 0; }
  /// Adds a sample (m, s) and returns the velocity, m/s. A sample whose time does not advance, or
  /// that is not finite, is ignored.
  Vec3 update(const Vec3& position, double time_s) noexcept;

private:
  struct Sample {
    Vec3 position;
    double time_s;
  };
  [[nodiscard]] const Sample& sample_before(std::size_t age) const noexcept {
    return samples_[(next_ + samples_.size() - 1 - age) % samples_.size()];
  }
  [[nodiscard]] double slope(int axis) const noexcept;

  std::array<Sample, kMaxWindow + 1> samples_{};
  std::size_t next_ = 0, count_ = 0;
  double bound_m_ = 0;
  Vec3 velocity_{};
};

} // namespace tactus::haptic

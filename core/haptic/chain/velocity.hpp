#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>

namespace tactus::haptic {

/// Velocity from positions that are known to a bound: first-order adaptive windowing, best fit
/// (Janabi-Sharifi, Hayward & Chen, IEEE Transactions on Control Systems Technology 8, 2000).
/// The window is the longest, up to 16 intervals, whose least-squares line passes every position
/// within the bound; its slope is the velocity. So a slow motion is averaged over many encoder
/// steps while a fast one is followed at once. Real times are used: late ticks do no harm.
/// Each axis has its own window. A bound of 0 gives the difference of the last two positions,
/// unless the line fits exactly.
class VelocityEstimator {
public:
  static constexpr std::size_t kMaxWindow = 16;

  /// bound_m: largest error of one position reading, e.g. half an encoder step.
  void set_bound(double bound_m) noexcept { bound_m_ = bound_m; }
  void reset() noexcept { count_ = 0; }
  /// m, s -> m/s. A time that does not advance, or an input that is not finite, is left out.
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

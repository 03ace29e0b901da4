#pragma once

#include "core/dsp/elementary.hpp"

#include <numbers>

namespace tactus {

/// Joins a sound to the one that replaces it abruptly, without a click. The jump of the value fades
/// along half a cosine of length kTime. The jump of the slope, which is known one sample later,
/// fades within kSlopeTime:
///     y = x + a w(n) + b n exp(-n/slope),   w = (1 + cos(pi n/length))/2.
/// Without a cut the samples pass unchanged.
class Seam {
public:
  static constexpr double kTime = 0.005, kSlopeTime = 0.0005; // s

  void prepare(double sample_rate) noexcept {
    length_ = kTime * sample_rate;
    slope_ = kSlopeTime * sample_rate;
  }
  /// The next samples belong to another sound.
  void cut() noexcept {
    if (sounds())
      age_ = 0;
  }
  [[nodiscard]] bool sounds() const noexcept { return last_ != 0 || before_ != 0; }
  double next(double x) noexcept {
    const double y = age_ < 0 ? x : x + correction(x);
    before_ = last_;
    last_ = y;
    return y;
  }

private:
  double correction(double x) noexcept {
    if (age_ == 0) { // the old sound would continue on the line through its last two samples
      jump_ = 2 * last_ - before_ - x;
      bend_ = last_ - before_ + x;
    } else if (age_ == 1) {
      bend_ -= x; // the old slope minus the new slope
    }
    const double n = age_++;
    if (n >= length_) {
      age_ = -1;
      return 0;
    }
    const double window = 0.5 + 0.5 * math::cos(std::numbers::pi * n / length_);
    return jump_ * window + (n > 0 ? bend_ * n * math::exp(-n / slope_) : 0);
  }

  double length_ = 240, slope_ = 24; // samples
  int age_ = -1;                     // samples since the cut; below 0: none
  double last_ = 0, before_ = 0;     // the last two outputs
  double jump_ = 0, bend_ = 0;
};

} // namespace tactus

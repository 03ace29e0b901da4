#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace tactus {

/// Joins the steps of a sampled-and-held position (an encoder read by a servo, a mouse) by straight
/// lines, so that a step from one sample to the next does not appear as a velocity peak.
///
/// A value that was held for n samples is connected to the next reading by a line of n samples, so
/// that the result is late by one reading. A signal that changes every sample passes unchanged. A
/// hold longer than kLongest counts as rest, so the line to the first reading after it takes
/// kLongest. The line does not catch up quickly with the remaining lag: it is no faster than the
/// larger of the last two speeds between readings. This adds a delay of at most one more reading.
class JoinedSteps {
public:
  static constexpr double kLongest = 0.05; ///< s

  /// Sample rate in Hz. The next value passes unchanged.
  void prepare(double sample_rate) noexcept {
    longest_ = std::max(1, static_cast<int>(kLongest * sample_rate));
    reset();
  }
  void reset() noexcept {
    held_ = 1;
    left_ = 0;
    first_ = true;
  }
  /// Joins the steps of the positions, in place.
  void run(std::span<float> position) noexcept {
    for (float& x : position) {
      if (x != target_) {
        left_ = static_cast<float>(held_);
        step_ = (x - value_) / left_;
        const float speed = std::abs(x - target_) / static_cast<float>(held_);
        const float limit = std::max(speed, held_ < longest_ ? last_speed_ : 0);
        if (!first_ && std::abs(step_) > limit) {
          left_ = std::abs(x - value_) / limit;
          step_ = std::copysign(limit, step_);
        }
        last_speed_ = first_ ? 0 : speed;
        first_ = false;
        target_ = x;
        held_ = 0;
      }
      held_ = std::min(held_ + 1, longest_);
      left_ = std::max(left_ - 1, 0.0F);
      value_ = target_ - left_ * step_;
      x = value_;
    }
  }

private:
  int longest_ = 1, held_ = 1; // samples: kLongest, age of the present reading
  float left_ = 0;             // samples until the end of the line
  float target_ = 0, value_ = 0, step_ = 0;
  float last_speed_ = 0; // between the last two readings, per sample
  bool first_ = true;    // no reading yet
};

} // namespace tactus

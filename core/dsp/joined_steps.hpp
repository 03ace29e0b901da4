#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace tactus {

/// Joins the steps of a position that is held between its readings (an encoder behind a servo, a
/// mouse) by straight lines, so that no step within a sample counts as a velocity.
///
/// A value that has been held for n samples is left over n samples: the result is late by one
/// reading. A signal that changes every sample passes as it is. Beyond kLongest nothing tells
/// readings from rest, so that the first reading of a hand that moves off is left slowly. What is
/// behind then is not made up by haste: the line is no faster than the hand was between this
/// reading and the last, or that and the one before, and late by up to one reading more.
class JoinedSteps {
public:
  static constexpr double kLongest = 0.05; ///< s

  /// Sample rate in Hz. The next value is taken as it is.
  void prepare(double sample_rate) noexcept {
    longest_ = std::max(1, static_cast<int>(kLongest * sample_rate));
    reset();
  }
  void reset() noexcept {
    held_ = 1;
    left_ = 0;
    first_ = true;
  }
  /// In place.
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
  int longest_ = 1, held_ = 1; // samples: the most, of the present value
  float left_ = 0;             // of the line
  float target_ = 0, value_ = 0, step_ = 0;
  float last_speed_ = 0; // between the last two readings, a sample
  bool first_ = true;    // no reading yet
};

} // namespace tactus

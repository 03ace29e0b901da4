#pragma once

#include <algorithm>
#include <span>

namespace tactus {

/// Joins the steps of a position that is held between its readings (an encoder behind a servo, a
/// mouse) by straight lines, so that no step within a sample counts as a velocity.
///
/// A value that has been held for n samples is left over n samples: the result is late by one
/// reading. A signal that changes every sample passes as it is. Beyond kLongest nothing tells
/// readings from rest.
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
  }
  /// In place.
  void run(std::span<float> position) noexcept {
    for (float& x : position) {
      if (x != target_) {
        left_ = held_;
        step_ = (x - value_) / static_cast<float>(left_);
        target_ = x;
        held_ = 0;
      }
      held_ = std::min(held_ + 1, longest_);
      if (left_ > 0)
        value_ = --left_ == 0 ? target_ : value_ + step_;
      x = value_;
    }
  }

private:
  int longest_ = 1, held_ = 1, left_ = 0; // samples: the most, of the present value, of the line
  float target_ = 0, value_ = 0, step_ = 0;
};

} // namespace tactus

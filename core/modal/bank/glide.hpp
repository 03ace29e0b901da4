#pragma once

#include <algorithm>
#include <cstddef>

namespace tactus::modal {

/// Leads a quantity from one target to the next along a quadratic B-spline whose knots lie kSegment
/// samples apart, whatever the rate at which targets come. Within a segment, 0 <= u < 1,
///   value = (1 - u)^2/2 old + (1/2 + u (1 - u)) middle + u^2/2 fresh,
/// so that value and slope are continuous, a target that moves at constant speed is followed
/// exactly (a segment and a half late), and a jump is spread over two segments: 1 kHz away from a
/// tone its trace is below -65 dB at 48 kHz. A target that comes within a segment waits for the
/// next; of several that wait the newest counts.
///
/// The glide keeps the time alone. Its owner holds the three values and a waiting target, and
/// exchanges them when start() or advance() says so.
class Glide {
public:
  static constexpr std::size_t kSegment = 512; ///< samples

  struct Blend {
    double old = 0, middle = 1, latest = 0; ///< weights of the three values, sum 1
  };
  enum class Exchange {
    kNone,
    kStart,  ///< middle <- fresh, fresh <- target
    kRotate, ///< old <- middle, middle <- fresh, fresh <- target if one waits
  };

  [[nodiscard]] bool moving() const noexcept { return moving_; }
  /// Old and middle, or middle and fresh, are known to be equal; at rest all are.
  [[nodiscard]] bool has_old() const noexcept { return has_old_; }
  [[nodiscard]] bool has_latest() const noexcept { return has_latest_; }
  /// A new target is there.
  [[nodiscard]] Exchange start() noexcept {
    if (moving_) {
      has_target_ = true;
      return Exchange::kNone;
    }
    moving_ = has_latest_ = true;
    position_ = 0;
    return Exchange::kStart;
  }
  /// Ends at once where the owner has put all three values to the target.
  void stop() noexcept { *this = {}; }
  [[nodiscard]] bool has_target() const noexcept { return has_target_; }
  /// A target that waits is not to come.
  void clear_target() noexcept { has_target_ = false; }

  /// Samples up to the next exchange.
  [[nodiscard]] std::size_t left() const noexcept { return kSegment - position_; }
  /// The sample after next ones; at 0 the first that is still to come.
  [[nodiscard]] Blend blend(std::size_t ahead) const noexcept {
    if (!moving_)
      return {};
    const double u = (static_cast<double>(position_ + ahead) + 0.5) / static_cast<double>(kSegment);
    Blend b{0.5 * (1 - u) * (1 - u), 0.5 + u * (1 - u), 0.5 * u * u};
    if (!has_old_) {
      b.middle += b.old;
      b.old = 0;
    }
    if (!has_latest_) {
      b.middle += b.latest;
      b.latest = 0;
    }
    return b;
  }
  /// Time passes, not beyond left(). After kRotate, look at waits() before the call to learn
  /// whether a target was taken.
  [[nodiscard]] Exchange advance(std::size_t samples) noexcept {
    if (!moving_)
      return Exchange::kNone;
    position_ += std::min(samples, left());
    if (position_ < kSegment)
      return Exchange::kNone;
    position_ = 0;
    has_old_ = has_latest_;
    has_latest_ = has_target_;
    has_target_ = false;
    moving_ = has_old_ || has_latest_;
    return Exchange::kRotate;
  }

private:
  std::size_t position_ = 0;
  bool moving_ = false, has_target_ = false, has_old_ = false, has_latest_ = false;
};

} // namespace tactus::modal

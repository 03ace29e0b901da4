#pragma once

#include <algorithm>
#include <cstddef>

namespace tactus::modal {

/// Interpolates a parameter smoothly between targets that arrive at any rate.
///
/// The value is a uniform quadratic B-spline whose knots are kSegment samples apart. Within a
/// segment, 0 <= u < 1,
///   value = (1 - u)^2/2 old + (1/2 + u (1 - u)) middle + u^2/2 latest,
/// so that value and slope are continuous. A target that moves at constant speed is followed
/// exactly, a segment and a half late. A jump is spread over two segments: at 48 kHz its sidebands
/// 1 kHz away from a tone are below -65 dB. A target that arrives within a segment waits for the
/// next segment; if several targets wait, the newest counts.
///
/// A Glide stores the time only. Its owner stores the three values and the waiting target, and
/// exchanges them as start() and advance() return.
class Glide {
public:
  static constexpr std::size_t kSegment = 512; ///< samples

  struct Blend {
    double old = 0, middle = 1, latest = 0; ///< weights of the three values, sum 1
  };
  enum class Exchange {
    kNone,
    kStart,  ///< middle <- latest, latest <- target
    kRotate, ///< old <- middle, middle <- latest, latest <- target if one waits
  };

  [[nodiscard]] bool moving() const noexcept { return moving_; }
  /// False: old equals middle, or latest equals middle, and need not be computed. At rest both are
  /// false.
  [[nodiscard]] bool has_old() const noexcept { return has_old_; }
  [[nodiscard]] bool has_latest() const noexcept { return has_latest_; }
  /// A new target has arrived.
  [[nodiscard]] Exchange start() noexcept {
    if (moving_) {
      has_target_ = true;
      return Exchange::kNone;
    }
    moving_ = has_latest_ = true;
    position_ = 0;
    return Exchange::kStart;
  }
  /// Ends the glide at once, after the owner has set all three values to the target.
  void stop() noexcept { *this = {}; }
  [[nodiscard]] bool has_target() const noexcept { return has_target_; }
  /// Drops the waiting target.
  void clear_target() noexcept { has_target_ = false; }

  /// Samples up to the next exchange.
  [[nodiscard]] std::size_t left() const noexcept { return kSegment - position_; }
  /// The weights `ahead` samples from now; 0: at the next sample.
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
  /// Moves on by at most left() samples. After kRotate a waiting target was taken if has_target()
  /// was true before the call.
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

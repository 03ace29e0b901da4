#pragma once

#include "core/geometry/vec3.hpp"

#include <algorithm>

namespace tactus::stress {

/// Linear interpolation of a vector towards targets that arrive at a low, irregular rate, so that
/// the force changes smoothly. The duration of a ramp is the time since the last target, at most 50
/// ms. fade() sets a duration of its own; ramps that start before its end last at least until then.
/// Times in s, on one clock that never goes back.
class VectorRamp {
public:
  static constexpr double kMax_s = 0.05;
  /// Takes the value at once.
  void jump(const Vec3& value) noexcept {
    value_ = target_ = value;
    fade_end_s_ = 0;
  }
  [[nodiscard]] const Vec3& target() const noexcept { return target_; }
  [[nodiscard]] bool moving() const noexcept { return !(value_ == target_); }
  void go(const Vec3& target, double now_s) noexcept {
    approach(target, now_s, std::clamp(now_s - since_s_, 0.0, kMax_s));
  }
  /// Goes to a target within fade_s.
  void fade(const Vec3& target, double now_s, double fade_s) noexcept {
    fade_end_s_ = now_s + fade_s;
    approach(target, now_s, fade_s);
  }
  [[nodiscard]] Vec3 at(double now_s) noexcept {
    if (value_ == target_)
      return value_;
    const double share = length_s_ > 0 ? (now_s - since_s_) / length_s_ : 1.0;
    return value_ = share >= 1 ? target_ : from_ + (target_ - from_) * std::max(0.0, share);
  }

private:
  void approach(const Vec3& target, double now_s, double length_s) noexcept {
    from_ = at(now_s);
    length_s_ = std::max(length_s, fade_end_s_ - now_s);
    since_s_ = now_s;
    target_ = target;
  }

  Vec3 value_{}, target_{}, from_{};
  double since_s_ = 0, length_s_ = 0, fade_end_s_ = 0;
};

} // namespace tactus::stress

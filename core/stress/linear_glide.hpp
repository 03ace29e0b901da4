#pragma once

#include "core/geometry/vec3.hpp"

#include <algorithm>

namespace tactus::stress {

/// A value that goes linearly to each new target, for as long as the targets were apart, 50 ms at
/// most: slow feedback becomes a smooth force. A fade lasts its own time, also when targets that
/// come meanwhile are closer together.
class LinearGlide {
public:
  static constexpr double kMax_s = 0.05;
  void jump(const haptic::Vec3& value) noexcept {
    value_ = target_ = value;
    fade_end_s_ = 0;
  }
  [[nodiscard]] const haptic::Vec3& target() const noexcept { return target_; }
  [[nodiscard]] bool moving() const noexcept { return !(value_ == target_); }
  void go(const haptic::Vec3& target, double now_s) noexcept {
    approach(target, now_s, std::clamp(now_s - since_s_, 0.0, kMax_s));
  }
  /// Takes `fade_s` for the way.
  void fade(const haptic::Vec3& target, double now_s, double fade_s) noexcept {
    fade_end_s_ = now_s + fade_s;
    approach(target, now_s, fade_s);
  }
  [[nodiscard]] haptic::Vec3 at(double now_s) noexcept {
    if (value_ == target_)
      return value_;
    const double share = length_s_ > 0 ? (now_s - since_s_) / length_s_ : 1.0;
    return value_ = share >= 1 ? target_ : from_ + (target_ - from_) * std::max(0.0, share);
  }

private:
  void approach(const haptic::Vec3& target, double now_s, double length_s) noexcept {
    from_ = at(now_s);
    length_s_ = std::max(length_s, fade_end_s_ - now_s);
    since_s_ = now_s;
    target_ = target;
  }

  haptic::Vec3 value_{}, target_{}, from_{};
  double since_s_ = 0, length_s_ = 0, fade_end_s_ = 0;
};

} // namespace tactus::stress

#include "core/haptic/device/linear_glide.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::haptic {

Vec3 LinearGlide::at(double time_s) const noexcept {
  const double passed_s = time_s - report_s_;
  if (!(passed_s < duration_s_))
    return target_;
  const double fraction = passed_s / duration_s_;
  return start_ * (1 - fraction) + target_ * fraction; // target_ - start_ could overflow
}

Vec3 LinearGlide::update(const Vec3& reported, double time_s) noexcept {
  if (!is_finite(reported) || !std::isfinite(time_s) || (started_ && time_s < time_s_))
    return position_;
  time_s_ = time_s;
  if (!started_) {
    started_ = true;
    target_ = reported;
    report_s_ = time_s;
    return position_ = reported;
  }
  if (reported != target_) {
    const double interval_s = time_s - report_s_;
    start_ = at(time_s);
    target_ = reported;
    report_s_ = time_s;
    duration_s_ = kStretch * (interval_s > kMaxInterval_s ? kUsualInterval_s
                                                          : std::max(interval_s, kMinInterval_s));
  }
  return position_ = at(time_s);
}

} // namespace tactus::haptic

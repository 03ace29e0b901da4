#include "core/haptic/servo/clock_map.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::haptic {

void ClockMap::follow(double host_ms, double servo_s) noexcept {
  const double passed_ms = 1e3 * std::max(0.0, servo_s - servo_s_);
  const double difference = host_ms - servo_s * 1e3 - ahead_ms_;
  servo_s_ = servo_s;
  if (!started_ || std::abs(difference) > kLeap_ms) {
    leaps_ += started_;
    started_ = true;
    ahead_ms_ += difference;
    return;
  }
  const double limit_ms = kMaxDrift * passed_ms;
  const double step_ms = std::clamp(difference, -limit_ms, limit_ms);
  ahead_ms_ += step_ms + drift_ * passed_ms;
  drift_ = std::clamp(drift_ + 1e-3 * kGain_per_s * step_ms, -kMaxDrift, kMaxDrift);
}

} // namespace tactus::haptic

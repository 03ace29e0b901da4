#include "core/haptic/device/hand.hpp"

#include <cmath>
#include <numbers>

namespace tactus::haptic {
namespace {
constexpr double kFollower_s = 0.02;
constexpr double kMaxYield_m = 1.0;
} // namespace

void NoiseOscillator::set(double frequency_hz, double damping_ratio, double rms,
                          double period_s) noexcept {
  const double w = 2.0 * std::numbers::pi * frequency_hz;
  step_ = MassSpringDamperStep::of(1.0, w * w, 2.0 * damping_ratio * w, period_s);
  rms_x_ = rms;
  rms_v_ = rms * w;
  const double pxx = rms_x_ * rms_x_, pvv = rms_v_ * rms_v_;
  const double qxx = pxx - (step_.xx * step_.xx * pxx + step_.xv * step_.xv * pvv);
  const double qxv = -(step_.xx * step_.vx * pxx + step_.xv * step_.vv * pvv);
  const double qvv = pvv - (step_.vx * step_.vx * pxx + step_.vv * step_.vv * pvv);
  noise_xx_ = std::sqrt(std::max(qxx, 0.0));
  noise_vx_ = noise_xx_ > 0.0 ? qxv / noise_xx_ : 0.0;
  noise_vv_ = std::sqrt(std::max(qvv - noise_vx_ * noise_vx_, 0.0));
}

void NoiseOscillator::start(Random& random) noexcept {
  x_ = rms_x_ * random.normal();
  v_ = rms_v_ * random.normal();
}

void NoiseOscillator::advance(Random& random) noexcept {
  const double first = random.normal(), second = random.normal();
  step_.advance(x_, v_, 0.0);
  x_ += noise_xx_ * first;
  v_ += noise_vx_ * first + noise_vv_ * second;
}

void Hand::set(const HandSettings& settings, double period_s) noexcept {
  origin_s_ += static_cast<double>(ticks_) * period_s_;
  ticks_ = 0;
  period_s_ = period_s;
  using Hold = HandSettings::Hold;
  const bool begins = settings.hold == Hold::kPerson &&
                      (settings_.hold != Hold::kPerson || settings_.seed != settings.seed);
  settings_ = settings;
  follower_ =
      MassSpringDamperStep::of(1.0, 1.0 / (kFollower_s * kFollower_s), 2.0 / kFollower_s, period_s);
  for (auto& axis : tremor_)
    axis.set(settings.tremor_hz, settings.tremor_damping, settings.tremor_m, period_s);
  for (auto& axis : wander_)
    axis.set(settings.wander_hz, 1.0, settings.wander_m, period_s);
  if (!begins)
    return;
  yield_displacement_ = yield_velocity_ = {};
  random_.seed(settings.seed);
  for (auto& axis : tremor_)
    axis.start(random_);
  for (auto& axis : wander_)
    axis.start(random_);
}

void Hand::set_path(Path path) noexcept {
  path_ = std::move(path);
  has_target_ = false;
  yield_displacement_ = yield_velocity_ = {};
  seek(0.0);
}

void Hand::set_target(const Vec3& target) noexcept {
  if (!is_finite(target))
    return;
  if (!has_target_)
    follower_state_ = point_at(path_, origin_s_ + static_cast<double>(ticks_) * period_s_);
  has_target_ = true;
  target_ = target;
}

void Hand::seek(double time_s) noexcept {
  origin_s_ = time_s;
  ticks_ = 0;
}

PathPoint Hand::intended() const noexcept {
  if (has_target_)
    return follower_state_;
  return point_at(path_, origin_s_ + static_cast<double>(ticks_) * period_s_);
}

PathPoint Hand::point() const noexcept {
  PathPoint point = intended();
  if (settings_.hold != HandSettings::Hold::kPerson)
    return point;
  point.position += yield_displacement_;
  point.velocity += yield_velocity_;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    point.position[axis] += tremor_[i].value() + wander_[i].value();
    point.velocity[axis] += tremor_[i].rate() + wander_[i].rate();
  }
  return point;
}

void Hand::advance(const Vec3& handle) noexcept {
  if (settings_.hold == HandSettings::Hold::kPerson) {
    // The person yields to the force of the spring, which contains the person's own tremor.
    // Yielding to the handle's distance from the intended point would integrate the tremor to a
    // random walk.
    if (settings_.yield_s > 0.0) {
      yield_velocity_ = (handle - point().position) * (1.0 / settings_.yield_s);
      yield_displacement_ = limited(yield_displacement_ + yield_velocity_ * period_s_, kMaxYield_m);
    } else {
      yield_velocity_ = {};
    }
    for (auto& axis : tremor_)
      axis.advance(random_);
    for (auto& axis : wander_)
      axis.advance(random_);
  }
  ++ticks_;
  if (!has_target_)
    return;
  for (int axis = 0; axis < 3; ++axis)
    follower_.advance(follower_state_.position[axis], follower_state_.velocity[axis],
                      target_[axis] / (kFollower_s * kFollower_s));
  follower_state_.buttons = 0;
}

} // namespace tactus::haptic

#include "core/haptic/chain/velocity.hpp"

namespace tactus::haptic {

Vec3 VelocityEstimator::update(const Vec3& position, double time_s) noexcept {
  if (!is_finite(position) || !std::isfinite(time_s))
    return velocity_;
  if (count_ > 0 && !(time_s > sample_before(0).time_s))
    return velocity_;
  samples_[next_] = {position, time_s};
  next_ = (next_ + 1) % samples_.size();
  count_ = std::min(count_ + 1, samples_.size());
  velocity_ = {slope(0), slope(1), slope(2)};
  return velocity_;
}

double VelocityEstimator::slope(int axis) const noexcept {
  if (count_ < 2)
    return 0.0;
  // Times and positions are taken relative to the newest sample, so that no large numbers cancel.
  const Sample& newest = sample_before(0);
  double best = 0.0;
  double sum_t = 0, sum_x = 0, sum_tt = 0, sum_tx = 0;
  for (std::size_t length = 1; length < count_; ++length) {
    const double t = sample_before(length).time_s - newest.time_s;
    const double x = sample_before(length).position[axis] - newest.position[axis];
    sum_t += t;
    sum_x += x;
    sum_tt += t * t;
    sum_tx += t * x;
    const double points = static_cast<double>(length + 1);
    const double spread = points * sum_tt - sum_t * sum_t;
    if (!(spread > 0.0))
      break;
    const double gradient = (points * sum_tx - sum_t * sum_x) / spread;
    const double offset = (sum_x - gradient * sum_t) / points;
    bool fits = true;
    for (std::size_t age = 0; age <= length && fits; ++age) {
      const double expected = offset + gradient * (sample_before(age).time_s - newest.time_s);
      const double error = sample_before(age).position[axis] - newest.position[axis] - expected;
      fits = std::abs(error) <= bound_m_ + 1e-15;
    }
    if (!fits && length > 1)
      break;
    best = gradient;
  }
  return std::isfinite(best) ? best : 0.0;
}

} // namespace tactus::haptic

#include "core/footstep/sole_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::footstep {
namespace {

constexpr double kLowPassHz = 200;
constexpr double kSlopeTime = 0.005;                            // s
constexpr double kFollowSlow = 0.5, kFollowFast = 0.02;         // s
constexpr double kOn = 0.05, kEarly = 0.025, kOff = 0.025;      // of the weight
constexpr double kLowestBaseline = 0.02;                        // of the weight
constexpr double kStepSlope = 4;                                // weights a second
constexpr double kShortestStance = 0.08, kShortestSwing = 0.06; // s
constexpr double kTouch = 0.01, kLook = 0.0027;                 // of the weight, s
constexpr double kSlowest = 0.02, kFastest = 2;                 // m/s
constexpr double kMostForce = 1e5;                              // N

} // namespace

bool Calibration::set(std::span<const double> points) noexcept {
  const std::size_t count = points.size() / 2;
  if (points.size() % 2 || count < kFewest || count > kMost)
    return false;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!std::isfinite(points[i]) || (i >= 2 && !(points[i] > points[i - 2])))
      return false;
  for (std::size_t i = 0; i < count; ++i) {
    reading_[i] = points[2 * i];
    force_[i] = points[2 * i + 1];
  }
  count_ = count;
  return true;
}

double Calibration::force(double reading) const noexcept {
  if (count_ == 0)
    return reading;
  std::size_t i = 1;
  while (i + 1 < count_ && reading > reading_[i])
    ++i;
  const double slope = (force_[i] - force_[i - 1]) / (reading_[i] - reading_[i - 1]);
  return force_[i - 1] + (reading - reading_[i - 1]) * slope;
}

void SoleChannel::prepare(double sample_rate) {
  rate_ = sample_rate;
  const double k = std::tan(std::numbers::pi * std::min(kLowPassHz / sample_rate, 0.45));
  const double norm = 1 / (1 + std::numbers::sqrt2 * k + k * k);
  b0_ = k * k * norm;
  b1_ = 2 * b0_;
  b2_ = b0_;
  a1_ = 2 * (k * k - 1) * norm;
  a2_ = (1 - std::numbers::sqrt2 * k + k * k) * norm;
  follow_slow_ = 1 - std::exp(-1 / (kFollowSlow * sample_rate));
  follow_fast_ = 1 - std::exp(-1 / (kFollowFast * sample_rate));
  const auto length = static_cast<std::size_t>(std::max(4.0, std::round(kSlopeTime * sample_rate)));
  if (length != recent_.size()) {
    recent_.assign(length, force_);
    at_ = 0;
    start_sums();
  }
}

void SoleChannel::reset() noexcept {
  force_ = slope_ = baseline_ = s1_ = s2_ = 0;
  std::fill(recent_.begin(), recent_.end(), 0.0);
  at_ = 0;
  start_sums();
}

void SoleChannel::start_sums() noexcept {
  // Oldest first, from the place that is written next.
  sum_ = weighted_ = 0;
  for (std::size_t i = 0; i < recent_.size(); ++i) {
    const double x = recent_[(at_ + i) % recent_.size()];
    sum_ += x;
    weighted_ += static_cast<double>(i) * x;
  }
}

void SoleChannel::next(double force_n, bool lifted, double lowest_n) noexcept {
  const double x = force_n;
  double y = b0_ * x + s1_;
  s1_ = b1_ * x - a1_ * y + s2_;
  s2_ = b2_ * x - a2_ * y;
  // A reading below the baseline is always a better one; drift upwards counts in the air alone.
  if (y < baseline_)
    baseline_ += follow_fast_ * (y - baseline_);
  else if (lifted)
    baseline_ += follow_slow_ * (y - baseline_);
  baseline_ = std::max(baseline_, lowest_n);
  force_ = std::max(0.0, y - baseline_);
  const std::size_t length = recent_.size();
  if (length == 0)
    return;
  const double oldest = recent_[at_];
  recent_[at_] = force_;
  if (++at_ == length)
    at_ = 0;
  // Everything moves one place towards the past.
  weighted_ += oldest - sum_ + static_cast<double>(length - 1) * force_;
  sum_ += force_ - oldest;
  if (at_ == 0)
    start_sums(); // rounding does not pile up
  const auto n = static_cast<double>(length);
  slope_ = 12 * (weighted_ - 0.5 * (n - 1) * sum_) / (n * (n * n - 1));
}

void SoleSensor::prepare(double sample_rate) {
  step_s_ = 1 / sample_rate;
  heel_.channel.prepare(sample_rate);
  ball_.channel.prepare(sample_rate);
}

void SoleSensor::set(double weight_n) noexcept {
  weight_n_ = std::clamp(weight_n, 1e-6, kMostForce);
}

void SoleSensor::reset() noexcept {
  for (Region* region : {&heel_, &ball_}) {
    region->channel.reset();
    region->down = region->landed = false;
    region->since_s = 1;
    region->touching_s = 0;
  }
}

void SoleSensor::update(Region& region, double force_n, bool stands, double& landing,
                        bool& lifted) noexcept {
  const double force = std::isfinite(force_n) ? std::clamp(force_n, -kMostForce, kMostForce) : 0;
  // The baseline waits until the foot is surely in the air.
  region.channel.next(force, !in_stance() && region.since_s > kShortestSwing,
                      -kLowestBaseline * weight_n_);
  region.since_s = std::min(region.since_s + step_s_, 1e3);
  const double level = region.channel.force() / weight_n_;
  const double slope = region.channel.slope() / weight_n_;
  region.touching_s = level > kTouch ? region.touching_s + step_s_ : 0;
  if ((region.down || stands) && !region.landed && region.touching_s >= kLook) {
    region.landed = true;
    // A heel's pad or a sole stiffens as it is pressed, F ~ x^2, so that slopes go with the square
    // of the speed.
    const double relative = std::max(slope, 0.0) / region.usual_slope;
    landing = std::clamp(region.usual_speed * std::sqrt(relative), kSlowest, kFastest);
  }
  if (!region.down) {
    if (region.since_s < kShortestSwing || !(level > kOn || (level > kEarly && slope > kStepSlope)))
      return;
    region.down = true;
    region.since_s = 0;
  } else if (region.since_s >= kShortestStance && level < kOff) {
    region.down = region.landed = false;
    region.since_s = 0;
    lifted = true;
  }
}

SoleState SoleSensor::next(double heel_reading, double ball_reading) noexcept {
  SoleState sole;
  const bool stood = in_stance();
  bool ball_up = false;
  update(heel_, heel_table_.force(heel_reading), false, sole.heel_landing, sole.heel_up);
  if (sole.heel_landing > 0)
    ball_.landed = ball_.down;
  update(ball_, ball_table_.force(ball_reading), heel_.landed, sole.ball_landing, ball_up);
  sole.heel_n = heel_.channel.force();
  sole.ball_n = ball_.channel.force();
  sole.heel_slope = heel_.channel.slope();
  sole.ball_slope = ball_.channel.slope();
  sole.toe_off = stood && !in_stance();
  return sole;
}

} // namespace tactus::footstep

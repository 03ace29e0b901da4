#include "core/footstep/sole_sensor.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace tactus::footstep {
namespace {

constexpr double kLowPassHz = 200;
constexpr double kSlopeTime = 0.005;                                 // s
constexpr double kSwingTimeConstant = 0.2, kFastTimeConstant = 0.02; // s
constexpr double kMaxDrift = 0.004;                                  // share of the weight per
                                                                     // second
constexpr double kFloor = 0.03, kNoise = 0.2;                        // s, time constants in the air
constexpr double kOn = 0.05, kOff = 0.025;                           // shares of the weight
constexpr double kMaxBaselineDrop = 0.02;                            // share of the weight
constexpr double kTouch = 0.0015, kMaxTouchThreshold = 0.08;         // shares of the weight
constexpr double kDeviations = 7;                                    // standard deviations of the
                                                                     // noise; a smaller rise is no
                                                                     // touch
constexpr double kMinNoiseWeight = 0.1;                              // reached after 20 ms in the
                                                                     // air
constexpr double kMaxLightTouch = 0.5;                               // s
constexpr double kMinStance = 0.08, kMinSwing = 0.06;                // s
constexpr double kMaxSwing = 0.4; // s, after which a foot might be put down slowly
constexpr double kStepSlope = 1;  // weights per second: slope of the slowest step
constexpr double kMaxCrosstalk = 0.08,
                 kCrosstalkTime = 20;              // share of the other region's force; s until it
                                                   // is forgotten
constexpr double kRest = 0.125;                    // share of the peak
constexpr double kMaxFallTime = 0.2;               // s, from half of the peak to kRest
constexpr double kStill = 0.005;                   // share of the weight, within 30 ms
constexpr double kJump = 0.06, kJumpChange = 0.02; // shares of the weight: change within one
                                                   // sample, and change after it
constexpr double kMaxJumpTime = 0.04;              // s; long enough for sensors read at 25 Hz or
                                                   // more
constexpr double kRiseTime = 0.0022, kFirmRiseTime = 0.0035;  // s
constexpr double kFirm = 0.008;                               // share of the weight
constexpr double kMinSensedSpeed = 0.02, kMaxSensedSpeed = 2; // m/s
constexpr double kStiffening = 1.5;                           // F ~ x^kStiffening
constexpr double kMaxForce = 1e5;                             // N

/// Typical landing speed, m/s, and slope, weights per second, when walking at 1.4 m/s in usual
/// shoes: of a heel that lands first; of a ball that lands first, as on stairs; of the part that
/// lands second.
struct TypicalLanding {
  double speed, slope;
};
constexpr TypicalLanding kHeelLanding{0.5, 26}, kBallLanding{0.5, 9}, kSecondRegion{0.3, 3.3};

} // namespace

bool Calibration::set(std::span<const double> points) noexcept {
  const std::size_t count = points.size() / 2;
  if (points.size() % 2 || count < kMinPoints || count > kMaxPoints)
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
  const double k = math::tan(std::numbers::pi * std::min(kLowPassHz / sample_rate, 0.45));
  const double norm = 1 / (1 + std::numbers::sqrt2 * k + k * k);
  b0_ = k * k * norm;
  b1_ = 2 * b0_;
  b2_ = b0_;
  a1_ = 2 * (k * k - 1) * norm;
  a2_ = (1 - std::numbers::sqrt2 * k + k * k) * norm;
  swing_coefficient_ = 1 - math::exp(-1 / (kSwingTimeConstant * sample_rate));
  fast_coefficient_ = 1 - math::exp(-1 / (kFastTimeConstant * sample_rate));
  floor_coefficient_ = 1 - math::exp(-1 / (kFloor * sample_rate));
  noise_coefficient_ = 1 - math::exp(-1 / (kNoise * sample_rate));
  const auto length = static_cast<std::size_t>(std::max(4.0, std::round(kSlopeTime * sample_rate)));
  if (length != window_.size()) {
    window_.assign(length, force_);
    write_index_ = 0;
    start_sums();
  }
}

void SoleChannel::reset() noexcept {
  force_ = slope_ = baseline_ = known_baseline_ = reading_ = delayed_ = s1_ = s2_ = 0;
  floor_ = rise_ = variance_ = noise_weight_ = 0;
  std::fill(window_.begin(), window_.end(), 0.0);
  write_index_ = 0;
  start_sums();
}

void SoleChannel::start_sums() noexcept {
  // Oldest first, from the index that is written next.
  sum_ = index_weighted_sum_ = 0;
  for (std::size_t i = 0; i < window_.size(); ++i) {
    const double x = window_[(write_index_ + i) % window_.size()];
    sum_ += x;
    index_weighted_sum_ += static_cast<double>(i) * x;
  }
}

double SoleChannel::touch_threshold_n(double weight_n) const noexcept {
  if (noise_weight_ < kMinNoiseWeight) // the foot was in the air for too short a time
    return kMaxTouchThreshold * weight_n;
  const double deviation = std::sqrt(variance_ / noise_weight_);
  return std::clamp(kDeviations * deviation, kTouch * weight_n, kMaxTouchThreshold * weight_n);
}

void SoleChannel::next(double force_n, Follow follow, double weight_n, bool free,
                       double touch_threshold_n, double crosstalk_n) noexcept {
  const double x = force_n;
  double y = b0_ * x + s1_;
  s1_ = b1_ * x - a1_ * y + s2_;
  s2_ = b2_ * x - a2_ * y;
  reading_ = y;
  delayed_ += floor_coefficient_ * (y - delayed_);
  // The baseline follows lower readings at once: by up to kMaxBaselineDrop below zero, or without
  // limit in a swing with a constant reading.
  const bool still = std::abs(change()) < kStill * weight_n + touch_threshold_n;
  const double lowest = follow == Follow::kSwing && still
                            ? y
                            : std::max(y, std::min(baseline_, -kMaxBaselineDrop * weight_n));
  if (y < baseline_)
    baseline_ += fast_coefficient_ * (lowest - baseline_);
  else if (follow == Follow::kSwing)
    baseline_ += swing_coefficient_ * (y - baseline_);
  else if (follow == Follow::kAir)
    baseline_ = std::min(y, baseline_ + kMaxDrift * weight_n / rate_);
  if (follow == Follow::kSwing || baseline_ < known_baseline_)
    known_baseline_ = baseline_;
  force_ = std::max(0.0, y - baseline_);
  rise_ = y - floor_;
  if (free) {
    // Only rises count as noise, not the fall as the foot leaves the ground. The rise of a touch is
    // clamped.
    const double up = std::clamp(rise_ - crosstalk_n, 0.0, touch_threshold_n);
    variance_ += noise_coefficient_ * (2 * up * up - variance_);
    noise_weight_ += noise_coefficient_ * (1 - noise_weight_);
    floor_ += floor_coefficient_ * (y - floor_);
  }
  const std::size_t length = window_.size();
  if (length == 0)
    return;
  const double oldest = window_[write_index_];
  window_[write_index_] = force_;
  if (++write_index_ == length)
    write_index_ = 0;
  // Every sample in the window becomes one sample older.
  index_weighted_sum_ += oldest - sum_ + static_cast<double>(length - 1) * force_;
  sum_ += force_ - oldest;
  if (write_index_ == 0)
    start_sums(); // prevents the accumulation of rounding errors
  const auto n = static_cast<double>(length);
  slope_ = 12 * (index_weighted_sum_ - 0.5 * (n - 1) * sum_) / (n * (n * n - 1));
}

void SoleSensor::prepare(double sample_rate) {
  step_s_ = 1 / sample_rate;
  heel_.channel.prepare(sample_rate);
  ball_.channel.prepare(sample_rate);
}

void SoleSensor::set(double weight_n) noexcept {
  weight_n_ = std::clamp(weight_n, 1e-6, kMaxForce);
}

void SoleSensor::reset() noexcept {
  for (Region* region : {&heel_, &ball_}) {
    region->channel.reset();
    region->down = region->loaded = false;
    region->swings = false;
    region->crosstalk = kMaxCrosstalk;
    region->since_s = 1;
    region->contact_s = region->last_n = 0;
    region->jump_s = -1;
    region->touch_threshold_n = kMaxTouchThreshold * weight_n_;
  }
}

void SoleSensor::watch_jump(Region& region, double force_n) noexcept {
  const double step_n = force_n - std::exchange(region.last_n, force_n);
  if (region.jump_s < 0) {
    if (region.down || step_n < kJump * weight_n_)
      return;
    region.jump_n = force_n;
    region.jump_s = 0;
  }
  region.jump_s += step_s_;
  // A contact that a slow sensor reads continues to change, so it is no jump.
  if (std::abs(force_n - region.jump_n) > kJumpChange * weight_n_)
    region.jump_s = -1;
}

bool SoleSensor::lands(Region& region, const Region& other, double& landing) noexcept {
  SoleChannel& channel = region.channel;
  const double noise_n = region.touch_threshold_n;
  const double other_n = std::max(other.channel.change(), 0.0);
  // Estimates the crosstalk as the smallest ratio of the rise here to the force under the other
  // region. A larger ratio also contains a load of this region.
  region.crosstalk += (kMaxCrosstalk - region.crosstalk) * step_s_ / kCrosstalkTime;
  if (other_n > kFirm * weight_n_ && channel.rise() >= 0)
    region.crosstalk =
        std::clamp((channel.rise() + 0.5 * noise_n) / other_n, 0.0, region.crosstalk);
  const double rise_n = channel.rise() - region.crosstalk * other_n;
  const bool touches = rise_n > (region.contact_s > 0 ? 0.5 : 1) * noise_n;
  region.contact_s = touches ? region.contact_s + step_s_ : 0;
  if (!touches)
    region.touch_threshold_n = channel.touch_threshold_n(weight_n_);
  if (region.since_s < kMinSwing)
    return false;
  if (region.jump_s >= 0) { // the jump is undecided until kMaxJumpTime; then a sensor was plugged
                            // in
    region.loaded = region.down = region.jump_s > kMaxJumpTime;
    return region.down;
  }
  // A firm contact exceeds the noise early, which leaves more time to measure its slope.
  const double rise_time = rise_n > kFirm * weight_n_ ? kFirmRiseTime : kRiseTime;
  const double on_n = kOn * weight_n_ + noise_n + region.crosstalk * other.channel.force();
  if (region.contact_s < rise_time && !(channel.force() > on_n && region.contact_s == 0))
    return false;
  region.down = true;
  region.loaded = false;
  const double slope =
      std::max(rise_n - noise_n, 0.0) / weight_n_ / std::max(region.contact_s, kRiseTime);
  channel.keep_baseline(slope > kStepSlope);
  const TypicalLanding& typical = other.down          ? kSecondRegion
                                  : &region == &heel_ ? kHeelLanding
                                                      : kBallLanding;
  landing = typical.speed * math::pow(slope / typical.slope, 1 / kStiffening);
  landing = std::clamp(landing, kMinSensedSpeed, kMaxSensedSpeed);
  return true;
}

bool SoleSensor::lifts(Region& region, const Region& other) noexcept {
  SoleChannel& channel = region.channel;
  const double level = channel.force() / weight_n_;
  region.loaded = region.loaded || level > kOn;
  region.peak = std::max(region.peak, level);
  if (level > 0.5 * region.peak)
    region.fall_s = region.rest_s = 0;
  else if (level > kRest * region.peak)
    region.fall_s += step_s_;
  const bool still = std::abs(channel.change()) < kStill * weight_n_ + region.touch_threshold_n;
  region.rest_s = still ? region.rest_s + step_s_ : 0;
  region.swings = region.loaded && level < kRest * region.peak && region.fall_s < kMaxFallTime;
  if (region.since_s < kMinStance)
    return false;
  if (region.swings && region.rest_s > kMinSwing) {
    channel.rebase();
    return true;
  }
  // A stance ends at kOff. A light touch ends below half of its threshold, or after kMaxLightTouch;
  // a longer touch counts as the pressure of the shoe itself.
  return region.loaded
             ? level < kOff + region.crosstalk * other.channel.force() / weight_n_
             : channel.rise() < 0.5 * region.touch_threshold_n || region.since_s > kMaxLightTouch;
}

void SoleSensor::update(Region& region, const Region& other, double force_n, double& landing,
                        bool& lifted) noexcept {
  const double force = std::isfinite(force_n) ? std::clamp(force_n, -kMaxForce, kMaxForce) : 0;
  SoleChannel& channel = region.channel;
  // The baseline is updated only when the foot is certainly in the air.
  const bool in_air = !in_stance() && region.since_s > kMinSwing && region.jump_s < 0;
  const bool swings = region.swings && region.since_s < kMaxSwing;
  using Follow = SoleChannel::Follow;
  channel.next(force,
               !in_air  ? Follow::kStance
               : swings ? Follow::kSwing
                        : Follow::kAir,
               weight_n_, !region.down && region.contact_s == 0, region.touch_threshold_n,
               region.crosstalk * std::max(other.channel.change(), 0.0));
  watch_jump(region, force);
  region.since_s = std::min(region.since_s + step_s_, 1e3);
  if (!region.down) {
    if (!lands(region, other, landing))
      return;
    region.since_s = region.peak = region.fall_s = region.rest_s = 0;
    region.jump_s = -1;
  } else if (lifts(region, other)) {
    region.down = false;
    region.contact_s = region.since_s = 0;
    channel.rebase_floor();
    lifted = true;
  }
}

SoleState SoleSensor::next(double heel_reading, double ball_reading) noexcept {
  SoleState sole;
  const bool was_in_stance = in_stance();
  bool ball_up = false;
  update(heel_, ball_, heel_table_.force(heel_reading), sole.heel_landing, sole.heel_up);
  update(ball_, heel_, ball_table_.force(ball_reading), sole.ball_landing, ball_up);
  sole.heel_n = heel_.channel.force();
  sole.ball_n = ball_.channel.force();
  sole.heel_slope = heel_.channel.slope();
  sole.ball_slope = ball_.channel.slope();
  sole.toe_off = was_in_stance && !in_stance();
  return sole;
}

} // namespace tactus::footstep

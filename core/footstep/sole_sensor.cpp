#include "core/footstep/sole_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::footstep {
namespace {

constexpr double kLowPassHz = 200;
constexpr double kSlopeTime = 0.005;                            // s
constexpr double kFollowSlow = 0.5, kFollowFast = 0.02;         // s
constexpr double kFloor = 0.03, kNoise = 0.2;                   // s, time constants in the air
constexpr double kOn = 0.05, kOff = 0.025;                      // of the weight
constexpr double kLowestBaseline = 0.02;                        // of the weight
constexpr double kTouch = 0.0015, kMaxTouch = 0.025;            // of the weight
constexpr double kDeviations = 7;                               // of noise that is no touch
constexpr double kKnown = 0.1;                                  // 20 ms in the air
constexpr double kLongestTouch = 0.5;                           // s
constexpr double kShortestStance = 0.08, kShortestSwing = 0.06; // s
constexpr double kLook = 0.0022, kLongLook = 0.0035;            // s
constexpr double kFirm = 0.008;                                 // of the weight
constexpr double kSlowest = 0.02, kFastest = 2;                 // m/s
constexpr double kStiffening = 1.5;                             // F ~ x^kStiffening
constexpr double kMaxForce = 1e5;                               // N

/// Landing speed in m/s and weights a second: of a heel that comes first and of a part that
/// follows, as a walker at 1.4 m/s in usual shoes has them; of a ball that comes first, as on
/// stairs.
struct Usual {
  double speed, slope;
};
constexpr Usual kHeelFirst{0.5, 26}, kBallFirst{0.5, 9}, kFollows{0.3, 3.3};

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
  const double k = std::tan(std::numbers::pi * std::min(kLowPassHz / sample_rate, 0.45));
  const double norm = 1 / (1 + std::numbers::sqrt2 * k + k * k);
  b0_ = k * k * norm;
  b1_ = 2 * b0_;
  b2_ = b0_;
  a1_ = 2 * (k * k - 1) * norm;
  a2_ = (1 - std::numbers::sqrt2 * k + k * k) * norm;
  follow_slow_ = 1 - std::exp(-1 / (kFollowSlow * sample_rate));
  follow_fast_ = 1 - std::exp(-1 / (kFollowFast * sample_rate));
  follow_floor_ = 1 - std::exp(-1 / (kFloor * sample_rate));
  follow_noise_ = 1 - std::exp(-1 / (kNoise * sample_rate));
  const auto length = static_cast<std::size_t>(std::max(4.0, std::round(kSlopeTime * sample_rate)));
  if (length != recent_.size()) {
    recent_.assign(length, force_);
    at_ = 0;
    start_sums();
  }
}

void SoleChannel::reset() noexcept {
  force_ = slope_ = baseline_ = s1_ = s2_ = 0;
  floor_ = rise_ = variance_ = known_ = 0;
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

double SoleChannel::touch_n(double weight_n) const noexcept {
  if (known_ < kKnown) // too short a time in the air
    return kMaxTouch * weight_n;
  const double deviation = std::sqrt(variance_ / known_);
  return std::clamp(kDeviations * deviation, kTouch * weight_n, kMaxTouch * weight_n);
}

void SoleChannel::next(double force_n, bool lifted, bool free, double touch_n,
                       double lowest_n) noexcept {
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
  rise_ = y - floor_;
  if (free) {
    // Rises alone count as noise: a foot that leaves the ground is none. A touch counts little.
    const double up = std::clamp(rise_, 0.0, touch_n);
    variance_ += follow_noise_ * (2 * up * up - variance_);
    known_ += follow_noise_ * (1 - known_);
    floor_ += follow_floor_ * (y - floor_);
  }
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
  weight_n_ = std::clamp(weight_n, 1e-6, kMaxForce);
}

void SoleSensor::reset() noexcept {
  for (Region* region : {&heel_, &ball_}) {
    region->channel.reset();
    region->down = region->loaded = false;
    region->since_s = 1;
    region->touching_s = 0;
    region->touch_n = kMaxTouch * weight_n_;
  }
}

void SoleSensor::update(Region& region, double force_n, bool stands, double& landing,
                        bool& lifted) noexcept {
  const double force = std::isfinite(force_n) ? std::clamp(force_n, -kMaxForce, kMaxForce) : 0;
  SoleChannel& channel = region.channel;
  const double touch_n = region.touch_n;
  // The baseline waits until the foot is surely in the air.
  channel.next(force, !in_stance() && region.since_s > kShortestSwing,
               !region.down && region.touching_s == 0, touch_n, -kLowestBaseline * weight_n_);
  region.since_s = std::min(region.since_s + step_s_, 1e3);
  const double level = channel.force() / weight_n_;
  if (!region.down) {
    const bool touches = channel.rise() > (region.touching_s > 0 ? 0.5 : 1) * touch_n;
    region.touching_s = touches ? region.touching_s + step_s_ : 0;
    if (!touches)
      region.touch_n = channel.touch_n(weight_n_);
    if (region.since_s < kShortestSwing)
      return;
    // A firm contact is told early: there is time to look longer at how hard it is.
    const double look = channel.rise() > kFirm * weight_n_ ? kLongLook : kLook;
    if (region.touching_s < look && !(level > kOn && region.touching_s == 0))
      return;
    region.down = true;
    region.loaded = false;
    region.since_s = 0;
    const double slope =
        std::max(channel.rise() - touch_n, 0.0) / weight_n_ / std::max(region.touching_s, kLook);
    const Usual& usual = stands ? kFollows : &region == &heel_ ? kHeelFirst : kBallFirst;
    landing = usual.speed * std::pow(slope / usual.slope, 1 / kStiffening);
    landing = std::clamp(landing, kSlowest, kFastest);
    return;
  }
  region.loaded = region.loaded || level > kOn;
  // A light touch ends where it began, or has become what the shoe itself presses; a stance ends at
  // kOff.
  const bool gone = region.loaded
                        ? level < kOff
                        : channel.rise() < 0.5 * touch_n || region.since_s > kLongestTouch;
  if (gone && region.since_s >= kShortestStance) {
    region.down = false;
    region.touching_s = region.since_s = 0;
    channel.land_on_floor();
    lifted = true;
  }
}

SoleState SoleSensor::next(double heel_reading, double ball_reading) noexcept {
  SoleState sole;
  const bool stood = in_stance();
  bool ball_up = false;
  update(heel_, heel_table_.force(heel_reading), ball_.down, sole.heel_landing, sole.heel_up);
  update(ball_, ball_table_.force(ball_reading), heel_.down, sole.ball_landing, ball_up);
  sole.heel_n = heel_.channel.force();
  sole.ball_n = ball_.channel.force();
  sole.heel_slope = heel_.channel.slope();
  sole.ball_slope = ball_.channel.slope();
  sole.toe_off = stood && !in_stance();
  return sole;
}

} // namespace tactus::footstep

#include "core/footstep/ground_reaction.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace tactus::footstep {
namespace {

using std::numbers::pi;
constexpr double kMaxTransient = 0.6;      // weights
constexpr double kDefaultSpeed = 1.4;      // m/s
constexpr double kShareShape = 0.8;        // the heel's share is 1/2 at 63 % of its fall
constexpr double kContactSlip = 0.2 / 1.4; // share of the walking speed: 3 mm in 30 ms at 1.4 m/s
constexpr double kMaxWalk = 2.5, kMinWalk = 0.3, kMaxRun = 8, kMinRun = 1.5; // m/s
constexpr double kMinSprint = 6; // m/s, above which runners land on the ball

// Effective masses behind a landing, as shares of the body's mass (docs/theory/footstep.md).
constexpr double kHeelWalking = 0.063, kHeelRunning = 0.053, kHeelCrouched = 0.037;
constexpr double kBallFirst = 0.017, kFoot = 0.0145;

} // namespace

struct GroundReaction::Shape {
  double speed, first, first_at, valley, valley_at, second, second_at, duty;
};

namespace {

/// Linear interpolation between the rows, over their first number.
template <class Row, std::size_t N> Row between(const std::array<Row, N>& rows, double speed) {
  std::size_t i = 0;
  while (i + 2 < N && speed > rows[i + 1].speed)
    ++i;
  const Row &a = rows[i], &b = rows[i + 1];
  const double t = std::clamp((speed - a.speed) / (b.speed - a.speed), 0.0, 1.0);
  const auto mix = [t](double p, double q) { return p + t * (q - p); };
  return {speed,
          mix(a.first, b.first),
          mix(a.first_at, b.first_at),
          mix(a.valley, b.valley),
          mix(a.valley_at, b.valley_at),
          mix(a.second, b.second),
          mix(a.second_at, b.second_at),
          mix(a.duty, b.duty)};
}

} // namespace

double Landing::peak(double speed) const noexcept {
  return mass * speed / kGravity * 0.5 * pi / kImpactTime;
}

Track heel_share_track(double heel_at, double ball_at, double release_at, double highest) noexcept {
  if (heel_at <= ball_at) {
    Track share(1);
    return share.hold(ball_at).to(0, release_at - ball_at, kShareShape);
  }
  // The heel takes over its share in a third of the time for which it is down.
  Track share(0);
  const double down = release_at - heel_at;
  return share.hold(heel_at).to(highest, 0.35 * down).hold(0.1 * down).to(0, 0.55 * down);
}

double GroundReaction::flight_s() const noexcept {
  return std::max(0.0, 0.5 * stride_s_ - stance_s_);
}

/// Mean of landings and transient over the stance, body weights.
double GroundReaction::landing_mean() const noexcept {
  const double landings =
      (heel_.mass * heel_.speed_m_per_s + ball_.mass * ball_.speed_m_per_s) / kGravity;
  return (landings + 0.5 * kTransientTime * transient_) / stance_s_;
}

void GroundReaction::set_share() noexcept {
  share_ = heel_share_track(heel_.at, ball_.at, release_at_, max_heel_share_);
}

void GroundReaction::set_walk(const Shape& shape) noexcept {
  const double inner = (shape.valley_at - shape.first_at) * 0.5 * (shape.first + shape.valley) +
                       (shape.second_at - shape.valley_at) * 0.5 * (shape.valley + shape.second);
  const double outer = shape.first_at * shape.first + (1 - shape.second_at) * shape.second;
  // Mean height of the flanks: 2 / pi for a sine, 1/2 for its square.
  const double height = (1 / (2 * shape.duty) - inner - landing_mean()) / outer;
  const double sine_share = std::clamp((height - 0.5) / (2 / pi - 0.5), 0.0, 1.0);
  const auto up = [&](Track& track) {
    track.to(shape.first, shape.first_at, sine_share)
        .to(shape.valley, shape.valley_at - shape.first_at);
  };
  const auto down = [&](Track& track) {
    track.to(shape.second, shape.second_at - shape.valley_at)
        .to(0, 1 - shape.second_at, sine_share);
  };
  load_ = first_half_ = Track(0);
  second_half_ = Track(shape.valley);
  up(first_half_);
  down(second_half_);
  up(load_);
  down(load_);
}

void GroundReaction::set_times(double steps_a_minute, double duty) noexcept {
  stride_s_ = 2 * 60 / steps_a_minute;
  stance_s_ = duty * stride_s_;
}

void GroundReaction::set_run(double speed, double shoe) noexcept {
  const double cadence = 150 + 8 * speed; // steps / min
  set_times(cadence, std::clamp(0.32 - 0.02 * speed, 0.16, 0.29) * cadence / 120);
  const double landing = 0.6 + 0.15 * speed;
  if (speed < kMinSprint) {
    heel_ = {0, landing, kHeelRunning};
    ball_ = {0.04, 0.6 * landing, kFoot};
    transient_ = kMaxTransient * shoe;
  } else { // the heel hardly comes down
    ball_ = {0, landing, kBallFirst};
    heel_ = {0.15, 0.2 * landing, kFoot};
    max_heel_share_ = 0.2;
  }
  const double mean = stride_s_ / (2 * stance_s_);
  const double peak = 0.5 * pi * (mean - landing_mean());
  load_ = first_half_ = Track(0);
  second_half_ = Track(peak);
  first_half_.to(peak, 0.5, 1);
  second_half_.to(0, 0.5, 1);
  load_.to(peak, 0.5, 1).to(0, 0.5, 1);
}

/// A crouched, careful walk at 0.4 of the speed, with short steps.
void GroundReaction::set_sneak(double speed) noexcept {
  const double slow = std::max(0.2, 0.4 * speed);
  set_times(60 * slow / (0.35 + 0.25 * slow), 0.78 - 0.12 * slow);
  heel_ = {0, 0.06 + 0.08 * slow, kHeelCrouched};
  ball_ = {0.25, 0.06 + 0.06 * slow, kFoot};
  release_at_ = 0.72;
  heel_up_at_ = 0.68;
  // Share of the stance with both feet on the ground, at its beginning and again at its end.
  const double both = (2 * duty() - 1) / (2 * duty());
  const double level = (1 / (2 * duty()) - landing_mean()) / (1 - both);
  load_ = first_half_ = Track(0);
  second_half_ = Track(level);
  first_half_.to(level, both).hold(0.5 - both);
  second_half_.hold(0.5 - both).to(0, both);
  load_.to(level, both).hold(1 - 2 * both).to(0, both);
}

void GroundReaction::set(const Walker& walker) noexcept {
  static constexpr std::array kWalkShapes{Shape{0.8, 1.02, 0.24, 0.86, 0.48, 1.02, 0.76, 0.66},
                                          Shape{1.1, 1.06, 0.23, 0.80, 0.48, 1.06, 0.76, 0.64},
                                          Shape{1.4, 1.13, 0.22, 0.72, 0.48, 1.10, 0.77, 0.62},
                                          Shape{1.8, 1.30, 0.20, 0.58, 0.46, 1.17, 0.78, 0.60}};
  static constexpr Shape kUp{1.4, 1.03, 0.26, 0.78, 0.50, 1.18, 0.79, 0.64};
  static constexpr Shape kDown{1.4, 1.50, 0.16, 0.58, 0.46, 0.90, 0.76, 0.65};

  const auto finite = [](double value, double fallback) {
    return std::isfinite(value) ? value : fallback;
  };
  weight_n_ = std::clamp(finite(walker.weight_n, Walker{}.weight_n), 0.0, 1e5);
  style_ = walker.style;
  const bool run = style_ == Style::kRun;
  const double speed = std::clamp(finite(walker.speed_m_per_s, kDefaultSpeed),
                                  run ? kMinRun : kMinWalk, run ? kMaxRun : kMaxWalk);
  const double shoe = std::clamp(finite(walker.shoe, Walker{}.shoe), 0.0, 1.0);
  const double pace = math::pow(speed / kDefaultSpeed, 0.8);
  const double walking_cadence = std::clamp(100 + 27.8 * (speed - 1), 70.0, 145.0); // steps / min

  transient_ = 0;
  contact_slip_ = kContactSlip * speed;
  heel_up_at_ = 0.62;
  release_at_ = 0.66;
  max_heel_share_ = 1;
  switch (style_) {
  case Style::kRun:
    set_run(speed, shoe);
    break;
  case Style::kSneak:
    set_sneak(speed);
    break;
  case Style::kUpstairs:
    set_times(0.77 * walking_cadence, kUp.duty);
    ball_ = {0, 0.1 + 0.15 * pace, kBallFirst};
    heel_ = {0.12, 0.1 + 0.08 * pace, kFoot};
    max_heel_share_ = 0.55;
    set_walk(kUp);
    break;
  case Style::kDownstairs:
    set_times(0.91 * walking_cadence, kDown.duty);
    ball_ = {0, 0.6 * pace, kBallFirst};
    heel_ = {0.14, 0.1 + 0.25 * pace, kFoot};
    max_heel_share_ = 0.6;
    set_walk(kDown);
    break;
  case Style::kWalk: {
    const Shape shape = between(kWalkShapes, speed);
    set_times(walking_cadence, shape.duty);
    heel_ = {0, 0.5 * pace, kHeelWalking};
    ball_ = {0.11, 0.3 * pace, kFoot};
    transient_ = kMaxTransient * shoe;
    set_walk(shape);
    break;
  }
  }
  set_share();
}

double GroundReaction::force(double x) const noexcept {
  if (!(x > 0 && x < 1))
    return 0;
  double weights = load_.at(x);
  const auto within = [&](double at, double length_s) {
    return (x - at) * stance_s_ / length_s; // time since `at`, relative to length_s
  };
  for (const Landing* landing : {&heel_, &ball_})
    if (const double u = within(landing->at, Landing::kImpactTime); u > 0 && u < 1)
      weights += landing->peak(landing->speed_m_per_s) * math::sin(pi * u);
  if (const double u = within(heel_.at, kTransientTime); transient_ > 0 && u < 1) {
    const double sine = math::sin(pi * u);
    weights += transient_ * sine * sine;
  }
  return weight_n_ * weights;
}

} // namespace tactus::footstep

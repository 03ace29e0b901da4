#include "core/footstep/movements.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::footstep {
namespace {

using std::numbers::pi;
constexpr double kStandingShare = 0.6;  // share of the load under the heels while standing
constexpr double kShift = 0.7;          // s, duration of the shift of the weight to one foot
constexpr double kFree = 0.6;           // share of kShift after which the other foot is free
constexpr double kPlacingSpeed = 0.15;  // m/s, speed of a foot that is put down to stand
constexpr double kPlacingMass = 0.0145; // effective mass of that foot, as a share of the body's
                                        // mass

Footfall::Impact impact(bool heel, double at_s, double speed, double mass,
                        double weight_n) noexcept {
  const Landing landing{0, speed, mass};
  return {heel, at_s, speed, weight_n * landing.peak(speed)};
}

} // namespace

Footfall stance(const GroundReaction& reaction, const StepVariation& vary) noexcept {
  Footfall step;
  const double stance_s = reaction.stance_s() * vary.time;
  const double force = reaction.weight_n() * vary.force;
  step.load = reaction.load().scaled(force, stance_s);
  const auto land = [&](bool heel, const Landing& landing, double speed_scatter, double roll) {
    const double speed = landing.speed_m_per_s * speed_scatter;
    return Footfall::Impact{heel, landing.at * roll * stance_s, speed, force * landing.peak(speed)};
  };
  step.impacts = {land(true, reaction.heel(), vary.heel_speed, vary.roll),
                  land(false, reaction.ball(), vary.ball_speed, vary.roll)};
  step.impacts[0].bell_n = force * reaction.transient();
  step.heel_share = heel_share_track(step.impacts[0].at_s, step.impacts[1].at_s,
                                     reaction.release_at() * stance_s, reaction.max_heel_share());
  step.heel_up_s = reaction.heel_up_at() * stance_s;
  // The foot slides over the ground until the contact sticks.
  Track& slip = reaction.ball_first() ? step.ball_slip : step.heel_slip;
  slip = Track(reaction.contact_slip());
  slip.to(0, Landing::kImpactTime);
  step.start();
  return step;
}

void pivot(Footfall& step, const GroundReaction& reaction, double angle_rad) noexcept {
  constexpr double kBallRadius = 0.04; // m
  const double stance_s = step.load.duration_s();
  const double from = 0.36 * stance_s, during = 0.42 * stance_s;
  step.heel_share = heel_share_track(step.impacts[0].at_s, step.impacts[1].at_s,
                                     std::max(from, step.impacts[1].at_s + 0.1 * stance_s),
                                     reaction.max_heel_share());
  step.heel_up_s = from;
  const double distance = std::abs(angle_rad) * kBallRadius * 2 / 3;
  step.ball_slip = Track(0);
  step.ball_slip.hold(from).to(0, during, 0, 2 * distance / during);
}

FootfallPair set_off(const GroundReaction& reaction) noexcept {
  FootfallPair pair;
  Footfall &support = pair.feet[0], &lifted = pair.feet[1];
  const double stance_s = reaction.stance_s();
  const bool run = reaction.flight_s() > 0;
  const double level = run ? 1 : reaction.second_half().at(0);
  // The other foot carries kFree / 4 of the weight on average over the shift; this foot carries the
  // rest.
  const double hump = 2 * (1 - 0.25 * kFree) - (0.5 + level);
  Track load(0.5);
  load.to(level, kShift, 0, hump);
  if (run) {
    // The push-off accelerates the body from rest to the take-off speed of each flight, g flight /
    // 2.
    const double rise = 0.7 * stance_s, fall = 0.5 * stance_s;
    const double peak =
        (0.5 * reaction.flight_s() + 0.5 * rise + fall) / (0.5 * rise + 2 / pi * fall);
    load.to(peak, rise).to(0, fall, 1);
    pair.next_start_s = load.duration_s() + reaction.flight_s();
  } else {
    load.append(reaction.second_half().scaled(1, stance_s));
    pair.next_start_s = kShift + 0.5 * reaction.stride_s() - reaction.middle() * stance_s;
  }
  support.load = load.scaled(reaction.weight_n(), 1);
  const double rest = load.duration_s() - kShift;
  support.heel_share = Track(kStandingShare);
  support.heel_share.hold(kShift).to(0, 0.4 * rest);
  support.heel_up_s = kShift + 0.3 * rest;
  lifted.load = Track(0.5 * reaction.weight_n());
  lifted.load.to(0, kFree * kShift);
  lifted.heel_share = Track(kStandingShare);
  lifted.heel_share.to(0, 0.6 * kFree * kShift);
  lifted.heel_up_s = 0.5 * kFree * kShift;
  for (Footfall& foot : pair.feet)
    foot.start();
  return pair;
}

FootfallPair halt(const GroundReaction& reaction) noexcept {
  // The last landing is softer, and so is the landing of the closing foot.
  constexpr double kLast = 0.8, kClosing = 0.5;
  FootfallPair pair;
  Footfall &last = pair.feet[0], &closing = pair.feet[1];
  const double stance_s = reaction.stance_s(), weight_n = reaction.weight_n();
  const bool run = reaction.flight_s() > 0;
  last = stance(reaction, {1, 1, kLast, kLast, 1});
  Track load(0);
  double level = 1;
  if (run) {
    const double rise = 0.5 * stance_s, fall = 0.7 * stance_s;
    double landings = 0;
    for (const Footfall::Impact& one : last.impacts)
      landings += one.impulse() / std::max(weight_n, 1e-9);
    const double peak =
        (0.5 * reaction.flight_s() - landings + 0.5 * fall + rise) / (0.5 * fall + 2 / pi * rise);
    load.to(peak, rise, 1).to(level, fall);
  } else {
    level = reaction.second_half().at(0);
    load = reaction.first_half().scaled(1, stance_s);
  }
  const double middle = load.duration_s();
  load.to(0.5, kShift, 0, 2 * (1 - 0.25 * kFree) - (0.5 + level));
  last.load = load.scaled(weight_n, 1);
  last.heel_up_s = -1;
  last.ends_standing = true;
  if (reaction.ball_first()) {
    last.heel_share = Track(0);
    last.heel_share.hold(last.impacts[0].at_s).to(kStandingShare, 0.5 * middle);
  } else {
    last.heel_share = Track(1);
    last.heel_share.hold(last.impacts[1].at_s).to(kStandingShare, middle);
  }
  last.start();

  pair.next_start_s = middle + (1 - kFree) * kShift;
  closing = stand(weight_n);
  closing.load = Track(0);
  closing.load.to(0.5 * weight_n, kFree * kShift);
  const Landing &heel = reaction.heel(), &ball = reaction.ball();
  closing.impacts = {impact(true, 0, kClosing * heel.speed_m_per_s, kPlacingMass, weight_n),
                     impact(false, 0, kClosing * ball.speed_m_per_s, kPlacingMass, weight_n)};
  constexpr double kFlat = 0.06; // s between the landings of heel and ball, which are nearly flat
  closing.impacts[reaction.ball_first() ? 0 : 1].at_s = kFlat;
  closing.heel_share = Track(reaction.ball_first() ? 0 : 1);
  closing.heel_share.hold(kFlat).to(kStandingShare, kFree * kShift - kFlat);
  closing.start();
  return pair;
}

Footfall stand(double weight_n) noexcept {
  Footfall foot;
  foot.load.to(0.5 * weight_n, 0.3);
  foot.heel_share = Track(0);
  foot.heel_share.hold(0.03).to(kStandingShare, 0.2);
  foot.impacts = {impact(true, 0.03, kPlacingSpeed, kPlacingMass, weight_n),
                  impact(false, 0, kPlacingSpeed, kPlacingMass, weight_n)};
  foot.ends_standing = true;
  foot.start();
  return foot;
}

Footfall lift(double load_n) noexcept {
  Footfall foot;
  foot.load = Track(load_n);
  foot.load.to(0, 0.15);
  foot.heel_share = Track(kStandingShare);
  foot.heel_share.to(0, 0.1);
  foot.heel_up_s = 0.08;
  foot.start();
  return foot;
}

Jump jump(double height_m, double weight_n) noexcept {
  const double height = std::clamp(height_m, kMinJump, kMaxJump);
  const double speed = std::sqrt(2 * kGravity * height);
  const double half = 0.5 * weight_n; // each foot
  Jump result;

  // Crouch: the body falls as the knees bend. Push-off: the force turns that downward speed into
  // the take-off speed. Small jumps have the same shape and take less time.
  const double quick = std::clamp(std::sqrt(height / 0.3), 0.35, 1.1);
  const double crouch = 0.3 * quick, rise = 0.2 * quick, fall = 0.28 * quick;
  constexpr double kUnweighted = 0.6;
  const double momentum = 0.5 * kUnweighted * crouch + speed / kGravity; // weight * s
  const double peak = (momentum + 0.5 * rise + fall) / (0.5 * rise + 2 / pi * fall);
  Track push_off(1);
  push_off.to(1, crouch, 0, -kUnweighted).to(peak, rise).to(0, fall, 1);
  result.push_off.load = push_off.scaled(half, 1);
  result.push_off.heel_share = Track(kStandingShare);
  result.push_off.heel_share.hold(crouch + rise).to(0, 0.6 * fall);
  result.push_off.heel_up_s = crouch + rise + 0.4 * fall;
  result.push_off.start();
  result.next_start_s = push_off.duration_s() + 2 * speed / kGravity;

  // Landing: the impacts of ball and heel; the legs absorb the rest of the momentum.
  constexpr double kBallMass = 0.04, kHeelAt = 0.025, kHeelTime = 0.06, kLegsRise = 0.08;
  const double highest = 1 + 5.5 * std::sqrt(height); // load of both feet, body weights
  const double legs = std::min(2.0, highest);
  const double ball = 2 * Landing{0, speed, kBallMass}.peak(speed); // force on both feet
  const double at_heel = 0.5 * (1 - math::cos(pi * (kHeelAt + 0.5 * kHeelTime) / kLegsRise));
  const double heel = std::max(0.0, highest - legs * at_heel);
  const double impulse = speed / kGravity - ball * 2 / pi * Landing::kImpactTime -
                         heel * 0.5 * kHeelTime - (0.5 * legs - 1) * kLegsRise;
  const double absorb = impulse / (0.5 * (legs - 1));
  Footfall& landing = result.landing;
  landing.load.to(legs * half, kLegsRise).to(half, absorb);
  landing.heel_share = Track(0);
  landing.heel_share.hold(kHeelAt).to(kStandingShare, 0.12);
  landing.impacts = {Footfall::Impact{true, kHeelAt, 0.5 * speed, 0, heel * half, kHeelTime},
                     Footfall::Impact{false, 0, speed, ball * half}};
  landing.ends_standing = true;
  landing.start();
  return result;
}

Footfall scuff(double length_m, double speed_m_per_s, double weight_n) noexcept {
  constexpr double kLoad = 0.06; // share of the weight
  Footfall foot;
  const double speed = std::clamp(speed_m_per_s, 0.3, 5.0);
  const double during = 2 * std::clamp(length_m, 0.01, 1.0) / speed; // half a cosine's mean is 1/2
  foot.load.to(kLoad * weight_n, 0.4 * during).to(0, 0.6 * during);
  foot.heel_share = Track(0);
  foot.ball_slip = Track(speed);
  foot.ball_slip.to(0, during);
  foot.impacts[1] = impact(false, 0, 0.1 * speed, kPlacingMass, weight_n);
  foot.start();
  return foot;
}

namespace {

constexpr double kMaxRampTime = 0.12, kRampShare = 0.25; // s; share of the time at full speed

/// A drag: one ramp loads the foot, another accelerates it; then the same in reverse order.
struct Sliding {
  Sliding(double length_m, double speed_m_per_s) noexcept {
    const double speed = std::clamp(speed_m_per_s, kMinDragSpeed, kMaxDragSpeed);
    const double whole = std::clamp(length_m, kMinDrag, kMaxDrag) / speed;
    ramp_s = std::min(kMaxRampTime, kRampShare * whole);
    slides_s = whole + ramp_s;
    slip.hold(ramp_s).to(speed, ramp_s).hold(whole - ramp_s).to(0, ramp_s);
  }
  double ramp_s, slides_s;
  Track slip{0};
};

} // namespace

double drag_speed(double length_m, double total_s) noexcept {
  // The duration is length over speed, plus both ramps of the load and half of each ramp of the
  // speed.
  const double speed = (1 + 3 * kRampShare) * length_m / total_s;
  return kRampShare * length_m / speed < kMaxRampTime ? speed
                                                      : length_m / (total_s - 3 * kMaxRampTime);
}

Footfall drag(double length_m, double speed_m_per_s, double weight_n) noexcept {
  const Sliding sliding(length_m, speed_m_per_s);
  Footfall foot;
  foot.ball_slip = foot.heel_slip = sliding.slip;
  foot.load.to(kDragLoad * weight_n, sliding.ramp_s).hold(sliding.slides_s).to(0, sliding.ramp_s);
  foot.heel_share = Track(0.3); // the foot trails on its ball
  foot.impacts[1] = impact(false, 0, kPlacingSpeed, kPlacingMass, weight_n);
  foot.start();
  return foot;
}

FootfallPair standing_drag(double length_m, double speed_m_per_s, double weight_n) noexcept {
  const Sliding sliding(length_m, speed_m_per_s);
  FootfallPair pair;
  pair.feet[0].ball_slip = pair.feet[0].heel_slip = sliding.slip;
  for (std::size_t i = 0; i < 2; ++i) {
    Footfall& foot = pair.feet[i];
    foot.load = Track(0.5 * weight_n);
    foot.load.to((i == 0 ? kDragLoad : 1 - kDragLoad) * weight_n, sliding.ramp_s)
        .hold(sliding.slides_s)
        .to(0.5 * weight_n, sliding.ramp_s);
    foot.heel_share = Track(kStandingShare);
    foot.ends_standing = true;
    foot.start();
  }
  pair.next_start_s = pair.feet[0].load.duration_s();
  return pair;
}

} // namespace tactus::footstep

#include "core/footstep/gait.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::footstep {
namespace {

/// The ball of the foot comes down after about this part of the stance, when walking.
constexpr double kFlatAt = 0.12;
constexpr double kHeelUpAt = 0.62;
/// Speeds at which heel and ball meet the ground at 1.4 m/s, and how they grow with the speed.
constexpr double kHeelSpeed = 0.5, kBallSpeed = 0.3, kUsualSpeed = 1.4, kGrowth = 0.8;

} // namespace

void Gait::prepare(double sample_rate) noexcept { step_s_ = 1 / sample_rate; }

void Gait::set(const Walker& walker, double variation) noexcept {
  walker_ = walker;
  reaction_.set(walker);
  variation_ = std::clamp(variation, 0.0, 0.5);
}

void Gait::reset() noexcept {
  until_contact_s_ = 0;
  next_foot_ = 0;
  for (auto& foot : steps_)
    for (Step& step : foot)
      step.under_way = false;
}

void Gait::walk(bool on) noexcept {
  if (on && !walking_)
    until_contact_s_ = 0;
  walking_ = on;
}

void Gait::step(std::size_t foot) noexcept {
  if (foot < kFeet)
    begin(foot);
}

void Gait::begin(std::size_t foot) noexcept {
  // A free one, else the oldest.
  Step& step =
      *std::max_element(steps_[foot].begin(), steps_[foot].end(), [](const Step& a, const Step& b) {
        return a.under_way != b.under_way ? a.under_way : a.under_way && a.time_s < b.time_s;
      });
  const auto vary = [this](double times) {
    return std::exp(times * variation_ * random_.normal());
  };
  step.reaction = reaction_;
  step.under_way = true;
  step.time_s = 0;
  step.stance_s = step.reaction.stance_s() * vary(1);
  step.scale = vary(1);
  const double pace = std::pow(std::clamp(walker_.speed_m_per_s, 0.3, 8.0) / kUsualSpeed, kGrowth);
  step.heel_speed = kHeelSpeed * pace * vary(4);
  step.ball_speed = kBallSpeed * pace * vary(5);
  // A runner lands on the whole foot.
  step.flat_s = (walker_.run ? 0.04 : kFlatAt) * step.stance_s * vary(4);
  step.landed = step.flat = step.heel_up = false;
  step.heel_n = step.ball_n = 0;
}

void Gait::advance(Step& step, SoleState& sole) noexcept {
  if (!step.under_way)
    return;
  if (!step.landed) {
    step.landed = true;
    sole.heel_landing = std::max(sole.heel_landing, step.heel_speed);
  }
  if (!step.flat && step.time_s >= step.flat_s) {
    step.flat = true;
    sole.ball_landing = std::max(sole.ball_landing, step.ball_speed);
  }
  step.time_s += step_s_;
  const double x = step.time_s / step.stance_s;
  const double force = step.scale * step.reaction.force(x);
  const double heel = force * GroundReaction::heel_share(x);
  const double ball = force - heel;
  sole.heel_n += heel;
  sole.ball_n += ball;
  sole.heel_slope += (heel - step.heel_n) / step_s_;
  sole.ball_slope += (ball - step.ball_n) / step_s_;
  step.heel_n = heel;
  step.ball_n = ball;
  if (!step.heel_up && x >= kHeelUpAt) {
    step.heel_up = true;
    sole.heel_up = true;
  }
  if (x >= 1) {
    step.under_way = false;
    sole.toe_off = true;
  }
}

void Gait::next(std::array<SoleState, kFeet>& feet) noexcept {
  feet = {};
  if (walking_) {
    if (until_contact_s_ <= 0) {
      begin(next_foot_);
      const double half_stride = 0.5 * reaction_.stride_s();
      until_contact_s_ += half_stride * std::max(0.2, 1 + variation_ * random_.normal());
      next_foot_ = 1 - next_foot_;
    }
    until_contact_s_ -= step_s_;
  }
  for (std::size_t i = 0; i < kFeet; ++i)
    for (Step& step : steps_[i])
      advance(step, feet[i]);
}

} // namespace tactus::footstep

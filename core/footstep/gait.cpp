#include "core/footstep/gait.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

namespace tactus::footstep {
namespace {

/// Landing speeds of the first steps, relative to steady walking.
constexpr double kSetOff[] = {0.75, 0.9};
constexpr double kMaxLog = 1.3863;    // ln 4
constexpr double kScuffLength = 0.15; // m
constexpr double kScuffSpeed = 1.4;   // speed of a swinging foot that is slowed down, relative to
                                      // the walking speed
constexpr double kScuffAt = 0.35;     // share of the swing
constexpr double kDragAt = 0.02, kClearance_s = 0.05; // s after take-off, s before landing

} // namespace

void Gait::prepare(double sample_rate) noexcept { step_s_ = 1 / sample_rate; }

void Gait::set(const Walker& walker, double variation) noexcept {
  walker_ = walker;
  if (!std::isfinite(walker_.speed_m_per_s))
    walker_.speed_m_per_s = Walker{}.speed_m_per_s;
  reaction_.set(walker_);
  variation_ = variation > 0 ? std::min(variation, 0.5) : 0;
}

void Gait::reset() noexcept {
  state_ = State::kAir;
  time_left_s_ = 0;
  next_foot_ = 0;
  steps_ = 0;
  turn_rad_ = jump_m_ = 0;
  landing_pending_ = false;
  swing_actions_ = {};
  unloaded_ = {};
  for (auto& foot : footfalls_)
    for (Footfall& footfall : foot)
      footfall.end();
}

double Gait::varied(double times) noexcept {
  // Limited to a factor of four.
  return math::exp(std::clamp(times * variation_ * random_.normal(), -kMaxLog, kMaxLog));
}

double Gait::swing_s() const noexcept { return reaction_.stride_s() - reaction_.stance_s(); }

bool Gait::on_ground(std::size_t foot) const noexcept {
  return std::any_of(footfalls_[foot].begin(), footfalls_[foot].end(),
                     [](const Footfall& one) { return one.active(); });
}

bool Gait::standing() const noexcept {
  return std::all_of(footfalls_.begin(), footfalls_.end(), [](const auto& foot) {
    return std::any_of(foot.begin(), foot.end(), [](const Footfall& one) { return one.at_rest(); });
  });
}

bool Gait::both_standing() const noexcept {
  return std::all_of(footfalls_.begin(), footfalls_.end(), [](const auto& foot) {
    return std::any_of(foot.begin(), foot.end(),
                       [](const Footfall& one) { return one.active() && one.ends_standing; });
  });
}

/// Lifts standing feet from the ground.
void Gait::lift_feet() noexcept {
  for (auto& foot : footfalls_)
    for (Footfall& one : foot)
      if (one.active() && one.ends_standing)
        one = lift(one.load.at(one.time_s()));
  state_ = State::kAir;
}

/// Starts a footfall in a free slot, or in place of the oldest.
Footfall& Gait::play(std::size_t foot, const Footfall& footfall) noexcept {
  auto& all = footfalls_[foot];
  Footfall& slot =
      *std::max_element(all.begin(), all.end(), [](const Footfall& a, const Footfall& b) {
        return a.active() != b.active() ? a.active() : a.active() && a.time_s() < b.time_s();
      });
  slot = footfall;
  in_use_[foot] =
      std::max(in_use_[foot], static_cast<std::size_t>(std::distance(all.data(), &slot)) + 1);
  return slot;
}

/// Replaces a standing footfall by one that begins with the same load.
void Gait::replace(std::size_t foot, const Footfall& footfall) noexcept {
  for (Footfall& one : footfalls_[foot])
    if (one.active() && one.ends_standing) {
      one = footfall;
      return;
    }
  play(foot, footfall);
}

void Gait::begin_step(std::size_t foot) noexcept {
  StepVariation vary{varied(1), varied(1), varied(4), varied(5), varied(4)};
  if (state_ == State::kWalking && steps_ < 2) {
    vary.heel_speed *= kSetOff[steps_];
    vary.ball_speed *= kSetOff[steps_];
  }
  Footfall planned = stance(reaction_, vary);
  if (turn_rad_ > 0)
    pivot(planned, reaction_, std::exchange(turn_rad_, 0.0));
  play(foot, planned);
}

void Gait::step(std::size_t foot) noexcept {
  if (foot >= kFeet)
    return;
  if (state_ == State::kStanding)
    lift_feet();
  begin_step(foot);
}

void Gait::turn(double angle_rad, std::size_t foot) noexcept {
  turn_rad_ = std::isfinite(angle_rad) ? std::min(std::abs(angle_rad), std::numbers::pi) : 0;
  if (!walk_requested_ && state_ != State::kHalting)
    step(foot);
}

void Gait::jump(double height_m) noexcept {
  jump_m_ = height_m > 0 ? std::clamp(height_m, kMinJump, kMaxJump) : 0;
}

void Gait::scuff(std::size_t foot) noexcept {
  if (foot < kFeet)
    swing_actions_[foot] = {SwingAction::Kind::kScuff, kScuffLength * varied(4),
                            kScuffSpeed * std::clamp(walker_.speed_m_per_s, 0.3, 3.0) * varied(2),
                            -1};
}

void Gait::drag(std::size_t foot, double length_m, double speed_m_per_s) noexcept {
  if (foot < kFeet && std::isfinite(length_m) && std::isfinite(speed_m_per_s))
    swing_actions_[foot] = {SwingAction::Kind::kDrag, length_m, speed_m_per_s, -1};
}

void Gait::begin_halt() noexcept {
  FootfallPair pair = footstep::halt(reaction_);
  play(next_foot_, pair.feet[0]);
  second_footfall_ = pair.feet[1];
  time_left_s_ = pair.next_start_s;
  next_foot_ = 1 - next_foot_;
  state_ = State::kHalting;
}

void Gait::begin_jump() noexcept {
  const Jump planned =
      footstep::jump(std::exchange(jump_m_, 0.0) * varied(1), reaction_.weight_n());
  for (std::size_t foot = 0; foot < kFeet; ++foot)
    replace(foot, planned.push_off);
  landing_ = planned.landing;
  landing_pending_ = true;
  time_left_s_ = planned.next_start_s;
  state_ = State::kBusy;
}

/// First movement of feet in the air.
void Gait::start_from_air() noexcept {
  if (jump_m_ > 0) {
    for (std::size_t foot = 0; foot < kFeet; ++foot)
      play(foot, stand(reaction_.weight_n()));
    state_ = State::kStanding;
  } else if (walk_requested_) {
    state_ = State::kWalking;
    time_left_s_ = 0;
    steps_ = 0;
  }
}

/// Starts requested scuffs and drags of feet that swing or are free.
void Gait::begin_swing_actions() noexcept {
  for (std::size_t foot = 0; foot < kFeet; ++foot) {
    SwingAction& swing = swing_actions_[foot];
    if (swing.kind == SwingAction::Kind::kNone)
      continue;
    const double weight_n = reaction_.weight_n();
    const bool scuffs = swing.kind == SwingAction::Kind::kScuff;
    if (state_ == State::kStanding) {
      if (!standing())
        continue;
      FootfallPair pair = standing_drag(swing.length_m, swing.speed_m_per_s, weight_n);
      replace(foot, pair.feet[0]);
      replace(1 - foot, pair.feet[1]);
      time_left_s_ = pair.next_start_s;
      state_ = State::kBusy;
    } else if (state_ == State::kBusy || on_ground(foot)) {
      swing.wait_s = -1;
      continue;
    } else if (state_ == State::kAir) {
      play(foot, scuffs ? footstep::scuff(swing.length_m, swing.speed_m_per_s, weight_n)
                        : footstep::drag(swing.length_m, swing.speed_m_per_s, weight_n));
    } else {
      // While walking: some time after take-off, if enough of the swing remains.
      if (swing.wait_s < 0)
        swing.wait_s = scuffs ? kScuffAt * swing_s() : kDragAt;
      swing.wait_s -= step_s_;
      const double time_left_s =
          time_left_s_ + (next_foot_ == foot ? 0 : 0.5 * reaction_.stride_s()) - kClearance_s;
      if (swing.wait_s > 0 || time_left_s < kScuffAt * swing_s())
        continue;
      Footfall planned;
      if (scuffs) { // half a cosine's mean is 1/2
        const double length = std::min(swing.length_m, 0.5 * swing.speed_m_per_s * time_left_s);
        planned = footstep::scuff(length, swing.speed_m_per_s, weight_n);
      } else { // at most as long as a stride, and fast enough to end within the swing
        const double length =
            std::min(swing.length_m, walker_.speed_m_per_s * reaction_.stride_s());
        planned = footstep::drag(length, drag_speed(length, time_left_s), weight_n);
      }
      planned.unloads_other = true;
      play(foot, planned);
    }
    swing = {};
  }
}

void Gait::update_state() noexcept {
  if (state_ == State::kAir)
    start_from_air();
  switch (state_) {
  case State::kWalking:
    if (time_left_s_ <= 0) {
      if (!walk_requested_ || jump_m_ > 0) {
        begin_halt();
        break;
      }
      begin_step(next_foot_);
      steps_ = std::min(steps_ + 1, 2);
      const double half_stride = 0.5 * reaction_.stride_s();
      time_left_s_ += half_stride * std::max(0.2, 1 + variation_ * random_.normal());
      next_foot_ = 1 - next_foot_;
    }
    break;
  case State::kHalting:
    if (time_left_s_ <= 0) {
      play(next_foot_, second_footfall_);
      next_foot_ = 1 - next_foot_;
      state_ = State::kStanding;
    }
    break;
  case State::kBusy:
    if (time_left_s_ <= 0) {
      state_ = State::kStanding;
      if (std::exchange(landing_pending_, false))
        for (std::size_t foot = 0; foot < kFeet; ++foot) {
          Footfall& one = play(foot, landing_);
          for (Footfall::Impact& impact : one.impacts)
            impact.speed_m_per_s *= varied(2);
        }
    }
    break;
  case State::kStanding:
    if (!both_standing()) { // step() has replaced a standing footfall
      lift_feet();
      break;
    }
    if (!(walk_requested_ || jump_m_ > 0) || !standing())
      break;
    if (jump_m_ > 0) {
      begin_jump();
    } else {
      const FootfallPair pair = set_off(reaction_);
      replace(1 - next_foot_, pair.feet[0]);
      replace(next_foot_, pair.feet[1]);
      time_left_s_ = pair.next_start_s;
      steps_ = 0;
      state_ = State::kWalking;
    }
    break;
  case State::kAir:
    break;
  }
}

void Gait::next(std::array<SoleState, kFeet>& feet) noexcept {
  for (SoleState& foot : feet)
    foot = {};
  update_state();
  begin_swing_actions();
  time_left_s_ -= step_s_;
  std::array<double, kFeet> unloaded_n{};
  for (std::size_t i = 0; i < kFeet; ++i) {
    for (std::size_t k = 0; k < in_use_[i]; ++k) {
      Footfall& footfall = footfalls_[i][k];
      footfall.advance(step_s_, feet[i]);
      if (footfall.active() && footfall.unloads_other)
        unloaded_n[1 - i] += footfall.force_n();
    }
    while (in_use_[i] > 0 && !footfalls_[i][in_use_[i] - 1].active())
      --in_use_[i];
  }
  for (std::size_t i = 0; i < kFeet; ++i)
    unload(i, unloaded_n[i], feet[i]);
}

/// Takes the load of a scuffing or dragging foot from the other one.
void Gait::unload(std::size_t foot, double force_n, SoleState& sole) noexcept {
  const double total_n = sole.heel_n + sole.ball_n;
  const double part = force_n > 0 && total_n > 0 ? std::min(force_n / total_n, 1.0) : 0;
  const double before = std::exchange(unloaded_[foot], part);
  if (part == 0 && before == 0)
    return;
  // The difference of (1 - part) force between two samples.
  const double rate = (part - before) / step_s_;
  sole.heel_slope = (1 - before) * sole.heel_slope - rate * sole.heel_n;
  sole.ball_slope = (1 - before) * sole.ball_slope - rate * sole.ball_n;
  sole.heel_n *= 1 - part;
  sole.ball_n *= 1 - part;
}

} // namespace tactus::footstep

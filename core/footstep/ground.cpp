#include "core/footstep/ground.hpp"

#include "core/footstep/floor_modes.hpp"
#include "core/footstep/shoe.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::footstep {
namespace {

constexpr std::size_t kHeel = 0, kBall = 1;
constexpr double kReferenceLandingSpeed = 0.5; // m/s
// What no walker does is no step: landings and slopes beyond these count as these.
constexpr double kMaxLandingSpeed = 4, kMaxLoadRate = 200; // m/s, reference weights a second
// Of the load's own rise and fall, what bends the boards before the joint is free.
constexpr double kBending = 0.8, kSpringBack = 0.2;
constexpr double kMinWeight = 1e-3, kMaxWeight = 20; // reference weights

/// What a landing puts into particles, times `heel` or `ball`. A cloud of energy E has events at a
/// rate ~ E and of energies ~ E: its sound has the power E^2. What sounds is to be a fixed part of
/// the landing's energy ~ m v^2, so E ~ sqrt(m) v.
double landing(double weight, double speed) noexcept {
  return std::sqrt(weight) * std::min(speed, kMaxLandingSpeed) / kReferenceLandingSpeed;
}

} // namespace

Ground::Ground() {
  seed(1);
  prepare(sample_rate_);
}

void Ground::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  for (StruckFloor& floor : floor_)
    floor.prepare(sample_rate);
  boards_.prepare(sample_rate);
  for (Particles& p : particles_)
    p.cloud.prepare(sample_rate);
  set(recipe_, shoe_);
}

void Ground::seed(std::uint64_t value) noexcept {
  random_.seed(value);
  for (double& d : detune_)
    d = random_.normal();
  for (Particles& p : particles_)
    p.cloud.seed(random_.next());
  boards_.seed(random_.next());
  for (StruckFloor& floor : floor_)
    floor.seed(random_.next());
}

void Ground::reset() noexcept {
  for (StruckFloor& floor : floor_)
    floor.reset();
  boards_.reset();
  for (Particles& p : particles_) {
    p.cloud.reset();
    p.heel.reset();
  }
  radiation_ = load_ = 0;
  heel_down_ = has_contact_position_ = false;
  silent_ = true;
}

void Ground::set(const Recipe& recipe, double shoe) noexcept {
  recipe_ = recipe;
  shoe_ = std::clamp(shoe, 0.0, 1.0);
  const double g = std::tan(std::numbers::pi * std::min(recipe.radiation_hz / sample_rate_, 0.45));
  radiation_gain_ = g / (1 + g);
  sole_factor_ = 1;
  if (recipe.solid.present) {
    for (StruckFloor& floor : floor_) {
      floor.set(recipe.solid, shoe_);
      floor.scale_modes(recipe.solid, detune_, 1, 1);
    }
    // What lies between sole and floor is pressed by the force of the landing. For one energy that
    // goes with k^(1/(a + 1)).
    const contact::ImpactLaw& floor = recipe.solid.law;
    const auto stiffness = [&](double hardness) {
      return in_series(floor, sole_law(hardness, floor.exponent)).stiffness;
    };
    sole_factor_ = std::pow(stiffness(shoe_) / stiffness(kReferenceShoe), 1 / (floor.exponent + 1));
  }
  if (recipe.friction.present) {
    boards_.set(recipe.friction);
    boards_.scale_modes(recipe.friction, detune_, 1, 1);
  }
  for (std::size_t i = 0; i < recipe.clouds; ++i) {
    const particle::CloudSettings& settings = recipe.cloud[i].settings;
    particles_[i].cloud.set(settings);
    particles_[i].heel.set(sample_rate_, settings.attack_s, settings.decay_s);
  }
}

void Ground::set_weight(double weight_n) noexcept {
  weight_ = weight_n > 0 ? std::min(weight_n / kReferenceWeight, kMaxWeight) : 0;
  root_weight_ = std::sqrt(std::max(weight_, kMinWeight));
}

/// Where floors and boards are touched, for a step whose landing was on another ground.
void Ground::draw_contact_positions() noexcept {
  has_contact_position_ = true;
  if (recipe_.solid.present)
    for (StruckFloor& floor : floor_)
      floor.draw_contact_positions(recipe_.solid);
  if (recipe_.friction.present)
    boards_.draw_contact_position(recipe_.friction);
}

void Ground::begin_step_variation() noexcept {
  has_contact_position_ = true;
  const double all_frequency = lognormal_factor(recipe_.vary_frequency, random_);
  const double all_decay = lognormal_factor(recipe_.vary_decay, random_);
  if (const SolidRecipe& solid = recipe_.solid; solid.present) {
    const double frequency = all_frequency * lognormal_factor(solid.scatter.frequency, random_);
    const double decay = all_decay * lognormal_factor(solid.scatter.decay, random_);
    for (StruckFloor& floor : floor_) {
      floor.scale_modes(solid, detune_, frequency, decay);
      floor.draw_contact_positions(solid);
    }
    speed_factor_ = lognormal_factor(solid.scatter.level, random_);
  }
  if (const FrictionRecipe& friction = recipe_.friction; friction.present) {
    const double frequency = all_frequency * lognormal_factor(friction.scatter.frequency, random_);
    boards_.scale_modes(friction, detune_, frequency,
                        all_decay * lognormal_factor(friction.scatter.decay, random_));
    boards_.draw_contact_position(friction);
  }
  // A heavier body sinks in deeper, for longer.
  const double decay_scale = root_weight_;
  for (std::size_t i = 0; i < recipe_.clouds; ++i) {
    const Scatter& scatter = recipe_.cloud[i].scatter;
    const particle::CloudSettings& settings = recipe_.cloud[i].settings;
    const double frequency = all_frequency * lognormal_factor(scatter.frequency, random_);
    const double decay = decay_scale * all_decay * lognormal_factor(scatter.decay, random_);
    particles_[i].cloud.vary(frequency, decay, lognormal_factor(scatter.level, random_));
    particles_[i].heel.set(sample_rate_, settings.attack_s, settings.decay_s * decay);
  }
}

Ground::Sound Ground::next(const SoleState& sole) noexcept {
  const bool heel_lands = sole.heel_landing > 0, ball_lands = sole.ball_landing > 0;
  const double heel_load = sole.heel_n / kReferenceWeight;
  const double ball_load = sole.ball_n / kReferenceWeight;
  const double load = heel_load + ball_load;
  if (silent_ && !heel_lands && !ball_lands && load <= 0) {
    load_ = 0;
    heel_down_ = false;
    return {};
  }
  // The first landing of a step; a heel that lands twice without leaving begins another.
  if (((heel_lands || ball_lands) && load_ <= 0) || (heel_lands && heel_down_))
    begin_step_variation();
  else if (!has_contact_position_) // a ground that comes under a foot which is already down
    draw_contact_positions();
  heel_down_ = heel_lands || (heel_down_ && load > 0);
  load_ = load;
  const auto slope = [](double newton_per_s) {
    return std::clamp(newton_per_s / kReferenceWeight, -kMaxLoadRate, kMaxLoadRate);
  };
  const double heel_slope = slope(sole.heel_slope), ball_slope = slope(sole.ball_slope);
  std::array<double, kRegions> felt{};
  bool silent = load <= 0;
  if (const SolidRecipe& solid = recipe_.solid; solid.present) {
    if (heel_lands && weight_ > 0)
      floor_[kHeel].land(solid, solid.heel_kg * weight_, sole.heel_landing * speed_factor_);
    if (ball_lands && weight_ > 0 && solid.ball > 0)
      floor_[kBall].land(solid, solid.ball_kg * weight_,
                         sole.ball_landing * speed_factor_ * solid.ball);
    floor_[kHeel].slide(sole.heel_n, sole.heel_slip);
    floor_[kBall].slide(sole.ball_n, sole.ball_slip);
    for (std::size_t r = 0; r < kRegions; ++r)
      if (floor_[r].active()) {
        felt[r] += solid.level * floor_[r].next();
        silent = false;
      }
  }
  if (recipe_.friction.present) {
    const double share = load > 0 ? std::clamp(heel_load / load, 0.0, 1.0) : 0;
    // The floor bends as load comes to it and as the load moves over it, from heel to ball: load
    // times the rate of the ball's share. Under a load that leaves it springs back, most of the way
    // only after the joint is free.
    const double change = heel_slope + ball_slope;
    const double bending = share * ball_slope - (1 - share) * heel_slope +
                           (change > 0 ? kBending : kSpringBack) * change;
    const double creak = recipe_.friction.level * boards_.next(recipe_.friction, load, bending);
    felt[kHeel] += share * creak;
    felt[kBall] += (1 - share) * creak;
    silent = silent && !boards_.active();
  }
  for (std::size_t i = 0; i < recipe_.clouds; ++i) {
    const CloudRecipe& cloud_recipe = recipe_.cloud[i];
    Particles& p = particles_[i];
    const auto power = [&](double slope_now, double slip_load) {
      return ((slope_now > 0 ? cloud_recipe.load * slope_now : -cloud_recipe.release * slope_now) +
              cloud_recipe.slide * slip_load) /
             root_weight_; // as landings: ~ sqrt(m)
    };
    const double heel_power = power(heel_slope, heel_load * std::abs(sole.heel_slip));
    const double ball_power = power(ball_slope, ball_load * std::abs(sole.ball_slip));
    if (heel_lands) {
      const double energy = cloud_recipe.heel * landing(weight_, sole.heel_landing);
      p.cloud.add_energy(energy);
      p.heel.add_energy(energy);
    }
    if (ball_lands)
      p.cloud.add_energy(cloud_recipe.ball * landing(weight_, sole.ball_landing));
    if (p.cloud.silent() && heel_power + ball_power <= 0)
      continue;
    const double heel_energy = p.heel.advance(heel_power);
    const double sound = sole_factor_ * p.cloud.next(heel_power + ball_power);
    const double energy = p.cloud.energy();
    const double share = energy > 0 ? std::min(heel_energy / energy, 1.0) : 0;
    felt[kHeel] += share * sound;
    felt[kBall] += (1 - share) * sound;
    silent = silent && p.cloud.silent();
  }
  for (double& f : felt)
    f *= recipe_.level;
  const double sum = felt[kHeel] + felt[kBall];
  // First-order high-pass by the trapezoidal rule.
  const double change = radiation_gain_ * (sum - radiation_);
  const double low = radiation_ + change;
  radiation_ = low + change;
  silent_ = silent;
  if (silent_)
    radiation_ = 0;
  return {recipe_.felt * felt[kHeel], recipe_.felt * recipe_.felt_ball * felt[kBall], sum - low};
}

} // namespace tactus::footstep

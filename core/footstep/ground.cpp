#include "core/footstep/ground.hpp"

#include "core/dsp/elementary.hpp"
#include "core/footstep/floor_modes.hpp"
#include "core/footstep/shoe.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::footstep {
namespace {

constexpr std::size_t kHeel = 0, kBall = 1;
constexpr double kReferenceLandingSpeed = 0.5; // m/s
// Landings and slopes are clamped to the range of human walkers.
constexpr double kMaxLandingSpeed = 4, kMaxLoadRate = 200; // m/s, reference weights per second
// Shares of the rise and of the fall of the load that bend the boards before the joint is free.
constexpr double kBending = 0.8, kSpringBack = 0.2;
constexpr double kMinWeight = 1e-3, kMaxWeight = 20; // reference weights

/// Energy that a landing gives to the particles, before the recipe's factor `heel` or `ball`. The
/// sound of a cloud of energy E has the power ~ E^2 (event rate ~ E, event energies ~ E). This
/// power should be a fixed share of the landing's energy ~ m v^2, so E ~ sqrt(m) v.
double landing_energy(double weight, double speed) noexcept {
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
  radiation_ = load_ = heel_share_ = 0;
  heel_down_ = has_contact_position_ = false;
  silent_ = true;
}

void Ground::set(const Recipe& recipe, double shoe) noexcept {
  recipe_ = recipe;
  shoe_ = std::clamp(shoe, 0.0, 1.0);
  const double g = math::tan(std::numbers::pi * std::min(recipe.radiation_hz / sample_rate_, 0.45));
  radiation_gain_ = g / (1 + g);
  sole_factor_ = 1;
  if (recipe.solid.present) {
    for (StruckFloor& floor : floor_) {
      floor.set(recipe.solid, shoe_);
      floor.scale_modes(recipe.solid, detune_, 1, 1);
    }
    // Particles between sole and floor are crushed by the force of the landing, which for a given
    // energy is ~ k^(1/(a + 1)).
    const contact::ImpactLaw& floor = recipe.solid.law;
    const auto stiffness = [&](double hardness) {
      return in_series(floor, sole_law(hardness, floor.exponent)).stiffness;
    };
    sole_factor_ =
        math::pow(stiffness(shoe_) / stiffness(kReferenceShoe), 1 / (floor.exponent + 1));
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

/// Draws the contact points of floors and boards only, for a step that landed on another ground.
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
  // The first landing of a step, or a second landing of the heel without the foot leaving.
  if (((heel_lands || ball_lands) && load_ <= 0) || (heel_lands && heel_down_))
    begin_step_variation();
  else if (!has_contact_position_) // the ground changed under a foot that is already down
    draw_contact_positions();
  heel_down_ = heel_lands || (heel_down_ && load > 0);
  load_ = load;
  const auto slope = [](double newton_per_s) {
    return std::clamp(newton_per_s / kReferenceWeight, -kMaxLoadRate, kMaxLoadRate);
  };
  const Load loads{heel_load, ball_load, slope(sole.heel_slope), slope(sole.ball_slope)};
  Vibration vibration{};
  bool silent = load <= 0;
  if (recipe_.solid.present)
    silent = !add_floor(sole, vibration) && silent;
  if (recipe_.friction.present)
    silent = !add_boards(loads, vibration) && silent;
  silent = !add_particles(sole, loads, vibration) && silent;
  for (double& v : vibration)
    v *= recipe_.level;
  const double sum = vibration[kHeel] + vibration[kBall];
  // First-order high-pass by the trapezoidal rule.
  const double change = radiation_gain_ * (sum - radiation_);
  const double low = radiation_ + change;
  radiation_ = low + change;
  silent_ = silent;
  if (silent_)
    radiation_ = 0;
  return {recipe_.felt * vibration[kHeel], recipe_.felt * recipe_.felt_ball * vibration[kBall],
          sum - low};
}

bool Ground::add_floor(const SoleState& sole, Vibration& vibration) noexcept {
  const SolidRecipe& solid = recipe_.solid;
  if (sole.heel_landing > 0 && weight_ > 0)
    floor_[kHeel].land(solid, solid.heel_kg * weight_, sole.heel_landing * speed_factor_);
  if (sole.ball_landing > 0 && weight_ > 0 && solid.ball > 0)
    floor_[kBall].land(solid, solid.ball_kg * weight_,
                       sole.ball_landing * speed_factor_ * solid.ball);
  floor_[kHeel].slide(sole.heel_n, sole.heel_slip);
  floor_[kBall].slide(sole.ball_n, sole.ball_slip);
  bool sounds = false;
  for (std::size_t r = 0; r < kRegions; ++r)
    if (floor_[r].active()) {
      vibration[r] += solid.level * floor_[r].next();
      sounds = true;
    }
  return sounds;
}

bool Ground::add_boards(const Load& load, Vibration& vibration) noexcept {
  const double total = load.heel + load.ball;
  if (total > 0)
    heel_share_ = std::clamp(load.heel / total, 0.0, 1.0);
  const double share = heel_share_;
  // The floor bends as the load grows and as it moves from heel to ball (load times the rate of the
  // ball's share). As the load falls it springs back, mostly after the joint is free.
  const double change = load.heel_slope + load.ball_slope;
  const double bending = share * load.ball_slope - (1 - share) * load.heel_slope +
                         (change > 0 ? kBending : kSpringBack) * change;
  const double creak = recipe_.friction.level * boards_.next(recipe_.friction, total, bending);
  vibration[kHeel] += share * creak;
  vibration[kBall] += (1 - share) * creak;
  return boards_.active();
}

bool Ground::add_particles(const SoleState& sole, const Load& load, Vibration& vibration) noexcept {
  bool sounds = false;
  for (std::size_t i = 0; i < recipe_.clouds; ++i) {
    const CloudRecipe& cloud_recipe = recipe_.cloud[i];
    Particles& p = particles_[i];
    const auto power = [&](double slope_now, double slip_load) {
      return ((slope_now > 0 ? cloud_recipe.load * slope_now : -cloud_recipe.release * slope_now) +
              cloud_recipe.slide * slip_load) /
             root_weight_; // ~ sqrt(m), as for landings
    };
    const double heel_power = power(load.heel_slope, load.heel * std::abs(sole.heel_slip));
    const double ball_power = power(load.ball_slope, load.ball * std::abs(sole.ball_slip));
    if (sole.heel_landing > 0) {
      const double energy = cloud_recipe.heel * landing_energy(weight_, sole.heel_landing);
      p.cloud.add_energy(energy);
      p.heel.add_energy(energy);
    }
    if (sole.ball_landing > 0)
      p.cloud.add_energy(cloud_recipe.ball * landing_energy(weight_, sole.ball_landing));
    if (p.cloud.silent() && heel_power + ball_power <= 0)
      continue;
    const double heel_energy = p.heel.advance(heel_power);
    const double sound = sole_factor_ * p.cloud.next(heel_power + ball_power);
    const double energy = p.cloud.energy();
    const double share = energy > 0 ? std::min(heel_energy / energy, 1.0) : 0;
    vibration[kHeel] += share * sound;
    vibration[kBall] += (1 - share) * sound;
    sounds = sounds || !p.cloud.silent();
  }
  return sounds;
}

} // namespace tactus::footstep

#include "core/footstep/ground.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::footstep {
namespace {

constexpr std::size_t kHeel = 0, kBall = 1;
constexpr double kUsualLanding = 0.5; // m/s
constexpr double kUsualSlope = 10;    // weights a second
// What no walker does is no step: landings and slopes beyond these count as these.
constexpr double kHardestLanding = 4, kSteepest = 200;
constexpr double kWobbleTime = 0.02; // s
constexpr double kMiddleShoe = 0.4, kShoeDecades = 1.6;

} // namespace

Ground::Ground() : solid_(kMostModes, 2, 1), boards_(kFrictionModes, 1, 1) {
  seed(1);
  prepare(sample_rate_);
}

void Ground::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  solid_.prepare(sample_rate);
  boards_.prepare(sample_rate);
  for (particle::Cloud& cloud : clouds_)
    cloud.prepare(sample_rate);
  wobble_kept_ = std::exp(-1 / (kWobbleTime * sample_rate));
  set(recipe_, shoe_);
}

void Ground::seed(std::uint64_t value) noexcept {
  random_.seed(value);
  for (double& d : detune_)
    d = random_.normal();
  for (particle::Cloud& cloud : clouds_)
    cloud.seed(random_.next());
  boards_.seed(0, random_.next());
}

void Ground::reset() noexcept {
  solid_.reset();
  boards_.reset();
  for (particle::Cloud& cloud : clouds_)
    cloud.reset();
  wobble_ = radiation_ = 0;
  silent_ = true;
}

double Ground::drawn(double deviation) noexcept {
  return std::exp(deviation * std::clamp(random_.normal(), -2.5, 2.5));
}

void Ground::tune(contact::TouchedBody& body, const ModesRecipe& modes,
                  std::span<const double> detune, double frequency, double decay) noexcept {
  std::array<contact::Mode, kMostModes> tuned{};
  Shape ear{};
  const auto count = std::min(static_cast<std::size_t>(modes.count), detune.size());
  double place = 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double relative = place * std::exp(modes.detune * detune[i]);
    tuned[i] = {modes.frequency_hz * frequency * relative,
                modes.t60_s * decay * std::pow(relative, -modes.t60_tilt), modes.mass_kg};
    ear[i] = std::pow(relative, -modes.tilt) * std::pow(10.0, modes.gains_db[i] / 20);
    place *= modes.ratio;
  }
  body.set_modes(std::span(tuned.data(), count));
  body.set_ear(0, std::span(ear.data(), count));
}

Ground::Shape Ground::shape(const ModesRecipe& modes) noexcept {
  Shape made{};
  for (double& s : made)
    s = drawn(modes.place);
  return made;
}

void Ground::set(const Recipe& recipe, double shoe) noexcept {
  recipe_ = recipe;
  shoe_ = std::clamp(shoe, 0.0, 1.0);
  const double angle = 2 * std::numbers::pi * std::min(recipe.radiation_hz / sample_rate_, 0.45);
  radiation_kept_ = std::exp(-angle);
  if (recipe.solid.present) {
    contact::ImpactLaw law = recipe.solid.law;
    law.stiffness *= std::pow(10.0, kShoeDecades * (shoe_ - kMiddleShoe));
    solid_.set_impact(kHeel, law, recipe.solid.heel_kg);
    solid_.set_impact(kBall, law, recipe.solid.ball_kg);
    tune(solid_, recipe.solid.modes, detune_, 1, 1);
  }
  if (recipe.friction.present) {
    boards_.set_friction(0, recipe.friction.law);
    tune(boards_, recipe.friction.modes, std::span(detune_).first(kFrictionModes), 1, 1);
  }
  for (std::size_t i = 0; i < recipe.clouds; ++i)
    clouds_[i].set(recipe.cloud[i].settings);
}

void Ground::new_place() noexcept {
  const double all_frequency = drawn(recipe_.vary_frequency);
  const double all_decay = drawn(recipe_.vary_decay);
  if (const SolidRecipe& solid = recipe_.solid; solid.present) {
    const double frequency = all_frequency * drawn(solid.scatter.frequency);
    const double decay = all_decay * drawn(solid.scatter.decay);
    tune(solid_, solid.modes, detune_, frequency, decay);
    solid_.set_place(kHeel, shape(solid.modes));
    solid_.set_place(kBall, shape(solid.modes));
    speed_factor_ = drawn(solid.scatter.level);
  }
  if (const FrictionRecipe& friction = recipe_.friction; friction.present) {
    const double frequency = all_frequency * drawn(friction.scatter.frequency);
    tune(boards_, friction.modes, std::span(detune_).first(kFrictionModes), frequency,
         all_decay * drawn(friction.scatter.decay));
    boards_.set_place(0, shape(friction.modes));
    friction_factor_ = drawn(friction.scatter.level);
  }
  for (std::size_t i = 0; i < recipe_.clouds; ++i) {
    const Scatter& scatter = recipe_.cloud[i].scatter;
    const double frequency = all_frequency * drawn(scatter.frequency);
    const double decay = all_decay * drawn(scatter.decay);
    clouds_[i].vary(frequency, decay, drawn(scatter.level));
  }
}

double Ground::rub(double weights, double slope) noexcept {
  const FrictionRecipe& friction = recipe_.friction;
  if (weights > 0.01) {
    wobble_ =
        wobble_kept_ * wobble_ + std::sqrt(1 - wobble_kept_ * wobble_kept_) * random_.normal();
    const double uneven = std::max(0.0, 1 + friction.wobble * wobble_);
    boards_.rub(0, (friction.pressed_n + friction.load_n * weights) * uneven,
                friction.slip_m_per_s * friction_factor_ * slope / kUsualSlope * uneven);
    rubbing_ = true;
  } else if (rubbing_) {
    boards_.rub(0, 0, 0);
    rubbing_ = false;
  }
  if (!rubbing_ && !boards_.active())
    return 0;
  boards_.step();
  return friction.level * boards_.hear(0);
}

Ground::Sound Ground::next(const SoleState& sole, double weight_n) noexcept {
  const double weights = (sole.heel_n + sole.ball_n) / weight_n;
  const bool heel_lands = sole.heel_landing > 0, ball_lands = sole.ball_landing > 0;
  if (silent_ && !heel_lands && !ball_lands && weights <= 0)
    return {};
  if (heel_lands)
    new_place();
  const double slope =
      std::clamp((sole.heel_slope + sole.ball_slope) / weight_n, -kSteepest, kSteepest);
  double felt = 0;
  bool silent = weights <= 0;
  if (recipe_.solid.present) {
    if (heel_lands)
      solid_.throw_mass(kHeel, 0, sole.heel_landing * speed_factor_);
    if (ball_lands && recipe_.solid.ball > 0)
      solid_.throw_mass(kBall, 0, sole.ball_landing * speed_factor_ * recipe_.solid.ball);
    // What was thrown just now is near only once a step has looked.
    if (heel_lands || ball_lands || solid_.active()) {
      solid_.step();
      felt += recipe_.solid.level * solid_.hear(0);
      silent = false;
    }
  }
  if (recipe_.friction.present) {
    felt += rub(weights, slope);
    silent = silent && !boards_.active();
  }
  for (std::size_t i = 0; i < recipe_.clouds; ++i) {
    const CloudRecipe& from = recipe_.cloud[i];
    const auto energy = [](double speed) {
      const double relative = std::min(speed, kHardestLanding) / kUsualLanding;
      return relative * relative;
    };
    if (heel_lands)
      clouds_[i].blow(from.heel * energy(sole.heel_landing));
    if (ball_lands)
      clouds_[i].blow(from.ball * energy(sole.ball_landing));
    felt += clouds_[i].next(slope > 0 ? from.load * slope : -from.release * slope);
    silent = silent && clouds_[i].silent();
  }
  felt *= recipe_.level;
  radiation_ += (1 - radiation_kept_) * (felt - radiation_);
  silent_ = silent;
  if (silent_)
    radiation_ = 0;
  return {felt, felt - radiation_};
}

} // namespace tactus::footstep

#include "core/footstep/struck_floor.hpp"

#include "core/dsp/elementary.hpp"
#include "core/footstep/floor_modes.hpp"
#include "core/footstep/shoe.hpp"

#include <algorithm>
#include <array>

namespace tactus::footstep {
namespace {

// Parts of a sole differ in mass and in speed.
constexpr double kMassDeviation = 0.4, kSpeedDeviation = 0.15;
constexpr double kFirstShare = 0.5;
constexpr double kMaxArrivalTime = 1; // s
/// Share of the friction force that excites the vertical vibration of the ground.
constexpr double kTangentialShare = 0.1;
/// A sole that has stopped sticks for a while; its tangential force decays through the leg.
constexpr double kHoldingTime = 0.015; // s
constexpr double kMinForce = 1e-3;     // N

/// Rubber or leather on a floor: coefficients 0.7 and 0.5, bristles of 0.1 MN/m.
contact::FrictionLaw sliding_sole(const SolidRecipe& solid) noexcept {
  return {0.7, 0.5, 0.1, 0.4, 1e5, 30, 0.4, solid.roughness};
}

} // namespace

StruckFloor::StruckFloor() : body_(kMaxModes, kMaxPatches + 1, 1) {}

void StruckFloor::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  normal_force_decay_ = math::exp(-1 / (kHoldingTime * sample_rate));
  body_.prepare(sample_rate);
}

void StruckFloor::seed(std::uint64_t value) noexcept {
  random_.seed(value);
  body_.seed(kSole, random_.next());
}

void StruckFloor::reset() noexcept {
  body_.reset();
  body_.rub(kSole, 0, 0);
  sliding_ = false;
  landing_samples_left_ = normal_force_n_ = 0;
}

void StruckFloor::set(const SolidRecipe& solid, double shoe) noexcept {
  law_ = in_series(solid.law, sole_law(shoe, solid.law.exponent));
  body_.set_friction(kSole, sliding_sole(solid));
}

void StruckFloor::scale_modes(const SolidRecipe& solid, std::span<const double> detune,
                              double frequency, double decay) noexcept {
  set_body_modes(body_, solid.modes, detune, frequency, decay);
}

void StruckFloor::draw_contact_positions(const SolidRecipe& solid) noexcept {
  const auto patches = static_cast<std::size_t>(solid.patches);
  for (std::size_t i = 0; i < patches; ++i)
    body_.set_contact_shape(i, draw_mode_shape(solid.modes, random_));
  std::array<double, kMaxModes> along = draw_mode_shape(solid.modes, random_);
  for (double& s : along)
    s *= kTangentialShare;
  body_.set_contact_shape(kSole, along);
}

void StruckFloor::land(const SolidRecipe& solid, double mass_kg, double speed_m_per_s) noexcept {
  const auto patches = static_cast<std::size_t>(solid.patches);
  std::array<double, kMaxPatches> share{};
  double rest = 0, last = 0;
  for (std::size_t i = 1; i < patches; ++i)
    rest += share[i] = lognormal_factor(kMassDeviation, random_);
  share[0] = patches > 1 ? kFirstShare : 1;
  for (std::size_t i = 0; i < patches; ++i) {
    if (i > 0)
      share[i] *= (1 - kFirstShare) / rest;
    body_.set_impact(i, law_, share[i] * mass_kg);
    if (i == 0) {
      body_.launch_mass(i, 0, speed_m_per_s);
      continue;
    }
    const double height = -solid.unevenness_m * math::log(1 - random_.uniform());
    const double speed = speed_m_per_s * lognormal_factor(kSpeedDeviation, random_);
    body_.launch_mass(i, height, speed);
    last = std::max(last, std::min(height / speed, kMaxArrivalTime));
  }
  for (std::size_t i = patches; i < kMaxPatches; ++i)
    body_.clear(i);
  landing_samples_left_ = std::max(landing_samples_left_, last * sample_rate_ + 2);
}

void StruckFloor::slide(double force_n, double speed_m_per_s) noexcept {
  const bool slides = force_n > 0 && speed_m_per_s != 0;
  if (slides)
    normal_force_n_ = force_n;
  else if (!sliding_)
    return;
  else
    normal_force_n_ *= normal_force_decay_;
  sliding_ = slides || normal_force_n_ > kMinForce;
  if (!sliding_)
    normal_force_n_ = 0;
  body_.rub(kSole, normal_force_n_, slides ? speed_m_per_s : 0);
}

double StruckFloor::next() noexcept {
  body_.step();
  landing_samples_left_ -= landing_samples_left_ > 0 ? 1 : 0;
  return body_.pickup_velocity(0);
}

} // namespace tactus::footstep

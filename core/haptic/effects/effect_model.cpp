#include "core/haptic/effects/effect_model.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <numbers>

namespace tactus::haptic {
namespace {
constexpr double kMinDepth_m = 1e-9; // a smaller depth of contact is rounding
using std::numbers::pi;
} // namespace

void EffectModel::begin() noexcept { started_ = has_mass_ = has_friction_anchor_ = false; }

Vec3 EffectModel::force(const Tick& tick, const State& state) noexcept {
  settings_.read();
  const EffectSettings& now = settings_.latest();
  const Vec3& x = state.position;
  if (!started_)
    position_ = x;
  started_ = true;

  active_force_ = {};
  if (now.constant)
    active_force_ += limited(now.constant->force_n, kMaxEffect_n);
  if (now.spring)
    active_force_ += limited((now.spring->centre - x) * now.spring->stiffness,
                             std::min(now.spring->max_n, kMaxEffect_n));

  Vec3 sum{};
  const double max_damping =
      max_passive_damping(damping_limit_.load(std::memory_order_relaxed), tick.period_s);
  if (now.viscous)
    sum -= limited(state.velocity * std::min(now.viscous->damping, max_damping), kMaxEffect_n);
  if (now.inertia)
    sum += inertia(*now.inertia, max_damping, tick, x);
  if (now.friction)
    sum += friction(*now.friction, x);
  if (now.texture) {
    const auto& texture = *now.texture;
    const double phase = 2 * pi * dot(x, texture.direction) / texture.wavelength_m;
    sum += limited(texture.direction * (texture.amplitude_n * math::sin(phase)), kMaxEffect_n);
  }
  if (now.relief)
    sum += relief(*now.relief, x);
  has_mass_ = now.inertia.has_value();
  has_friction_anchor_ = now.friction.has_value();
  position_ = x;
  return sum;
}

/// A mass m with position p and velocity u, coupled to the handle (x, v) by k and b:
///   m u' = k (x - p) + b (v - u),   p' = u
/// by the backward Euler rule, with v the difference quotient of the positions. This discrete
/// system is passive for any parameters: every step lowers m u^2/2 + k (x - p)^2/2 by at least the
/// energy that it gives out. Only the zero-order hold of the force creates energy, as for a spring
/// k and a damper b. Below the frequency sqrt(k/m) the hand feels the mass m, above it k and b: the
/// virtual coupling of Colgate, Stanley & Brown (IROS 1995).
Vec3 EffectModel::inertia(const EffectSettings::Inertia& inertia, double max_damping,
                          const Tick& tick, const Vec3& position) noexcept {
  const double m = inertia.mass_kg, k = inertia.stiffness;
  const double b = std::min(inertia.damping, max_damping);
  const double period = tick.period_s;
  const Vec3 velocity = (position - position_) * (1.0 / period);
  if (!has_mass_) {
    mass_position_ = position;
    mass_velocity_ = {};
  }
  mass_velocity_ =
      (mass_velocity_ * (m / period) + (position - mass_position_) * k + velocity * b) *
      (1.0 / (m / period + k * period + b));
  mass_position_ += mass_velocity_ * period;
  const Vec3 force = (mass_position_ - position) * k + (mass_velocity_ - velocity) * b;
  if (!is_finite(force) || !is_finite(mass_position_) || !is_finite(mass_velocity_)) {
    mass_position_ = position;
    mass_velocity_ = {};
    return {};
  }
  return limited(force, kMaxEffect_n);
}

/// Coulomb friction with presliding: a spring to an anchor, which follows the handle at the
/// distance F/k once the spring is stretched to it. This is an associated plastic law and therefore
/// passive.
Vec3 EffectModel::friction(const EffectSettings::Friction& friction,
                           const Vec3& position) noexcept {
  if (!has_friction_anchor_ || !is_finite(friction_anchor_))
    friction_anchor_ = position;
  friction_anchor_ =
      position + limited(friction_anchor_ - position, friction.force_n / friction.stiffness);
  return limited((friction_anchor_ - position) * friction.stiffness, kMaxEffect_n);
}

/// A groove of height h <= 0 changes the contact force k d to k (d + h) along the tilted normal n -
/// h' t (d: the depth, t: the direction of the grooves). This force is the gradient of k (d +
/// h)^2/2, so that a closed path does no work. The lateral part is the force by which a shape is
/// perceived (Robles-De-La-Torre & Hayward, Nature 412, 2001).
Vec3 EffectModel::relief(const EffectSettings::Relief& relief,
                         const Vec3& position) const noexcept {
  if (!scene_ || !scene_force_ || scene_->touches().empty())
    return {};
  const Vec3& normal = scene_->touches()[0].normal;
  const double depth = dot(scene_->proxy() - position, normal);
  const double contact_force = dot(*scene_force_, normal);
  if (!(depth > kMinDepth_m) || !(contact_force > 0))
    return {};
  const Vec3 along = relief.direction - normal * dot(relief.direction, normal);
  const double phase = 2 * pi * dot(position, along) / relief.wavelength_m;
  const double height = 0.5 * relief.depth_m * (math::cos(phase) - 1);
  const double slope = -relief.depth_m * pi / relief.wavelength_m * math::sin(phase);
  const double modulated_force = contact_force * std::max(0.0, depth + height) / depth;
  return limited(normal * (modulated_force - contact_force) - along * (modulated_force * slope),
                 kMaxEffect_n);
}

} // namespace tactus::haptic

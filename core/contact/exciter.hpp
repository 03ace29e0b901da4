#pragma once

#include "core/contact/friction.hpp"
#include "core/contact/impact.hpp"
#include "core/contact/modal_body.hpp"
#include "core/dsp/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tactus::contact {

/// What a body survives; numbers from outside are held within.
inline constexpr double kMaxForce = 1e7;    ///< N, from outside
inline constexpr double kMaxSpeed = 1e4;    ///< m/s
inline constexpr double kMaxDistance = 1e3; ///< m
inline constexpr double kMaxState = 1e60;   ///< sqrt(J), N; beyond it all starts anew

/// Velocity at the end of a step from the step's mean and the mean of the one before.
[[nodiscard, gnu::always_inline]] inline double extrapolate_velocity(double mean,
                                                                     double mean_before) noexcept {
  return mean + 0.5 * (mean - mean_before);
}

/// The same at a step's beginning, where forces may turn the velocity round in every step: halfway
/// between the mean that would follow from the last step's force and the mean before.
[[nodiscard, gnu::always_inline]] inline double expected(double mean_with_last_force,
                                                         double mean_before) noexcept {
  return 0.5 * (mean_with_last_force + mean_before);
}

/// What a completed contact was like.
struct ImpactRecord {
  double duration_s = 0;
  double impulse_ns = 0;
  double peak_n = 0; ///< mean of the step, the largest
};

/// One contact's part in a step with others: docs at ContactSystem. Velocities are means of the
/// step, of the exciter against the body.
struct ContactTerm {
  double own_free_velocity = 0; ///< the exciter's own without the contact's force
  double own_mobility = 0;      ///< its own mobility, m/(N s): how a force slows it down
  double free = 0;              ///< relative, without any contact's force
  LinearForce law;
  double force = 0, mean = 0; ///< N; m/s
  bool acts = false, may_be_negative = false;

  /// The only one, on a place of this mobility, the exciter's own counted in.
  [[gnu::always_inline]] void solve(double mobility) noexcept {
    const double inverse_denominator = 1 / (1 + law.slope_ns_per_m * mobility);
    mean = (free - mobility * law.offset_n) * inverse_denominator;
    force = (law.offset_n + law.slope_ns_per_m * free) * inverse_denominator;
  }
};

/// What touches a body at one place: nothing, a mass that strikes it or a surface that rubs it.
struct Exciter {
  enum class Kind { kNone, kImpact, kFriction };
  Kind kind = Kind::kNone;

  // Impact: a mass that flies, at `position_m` (into the body) with `velocity`.
  Impact impact;
  double mass_kg = 0.01;
  bool held = false; ///< its motion is given, as if its mass were infinite
  double position_m = -1, velocity_m_per_s = 0;
  double external_force_n = 0; ///< on the mass, into the body, until changed
  bool impulsive = false; ///< too short for the finest steps: an impulse with the exact restitution
  ImpactRecord ongoing, last;
  std::size_t impact_count = 0; ///< completed so far

  // Friction: a surface that moves as it likes.
  Friction friction;
  double normal_force_n = 0, rubbing_m_per_s = 0;
  Random noise = Random();
  double last_force_n = 0; ///< of the last step

  // Both.
  double depth_m = 0;               ///< penetration; friction: unused
  double approach_m_per_s = 0;      ///< relative velocity, its rate
  double mean_velocity_m_per_s = 0; ///< of the last step
  double force_n = 0;               ///< mean of the last sample; of a step while it runs
  double impulse_ns = 0;            ///< of the sample so far
  double dissipated_j = 0;          ///< by friction in the last sample
  bool near = false;                ///< takes part in the steps
  bool depth_valid = false;         ///< depth and approach follow from the steps before
  std::size_t level = 0;            ///< of steps that it needs

  // Of its place on the body.
  std::array<double, kLevels> mobility{}; ///< m/(N s): mean velocity of a step for a force in it
  double impulse_mobility = 0;            ///< 1/kg: change of velocity for an impulse
  double inverse_mass = 100,
         effective_mass_kg = 0.01; ///< 1/mass_kg, 0 where held; 1/impulse_mobility
  double level_energy_j = -1;      ///< energy of the contact for which `level` was found

  [[nodiscard]] double energy() const noexcept {
    if (kind == Kind::kImpact)
      return (held ? 0.0 : 0.5 * mass_kg * velocity_m_per_s * velocity_m_per_s) +
             impact.stored_j() + impact.energy_account_j();
    return kind == Kind::kFriction ? friction.stored_j() : 0.0;
  }

  /// A held striker moves at this velocity from now on.
  void move_at(double velocity) noexcept {
    const double next = bounded(velocity, kMaxSpeed);
    approach_m_per_s += next - velocity_m_per_s;
    mean_velocity_m_per_s += next - velocity_m_per_s;
    velocity_m_per_s = next;
  }
  /// A friction's surface presses and moves so from now on.
  void rub(double normal_force, double velocity) noexcept {
    const double next = bounded(velocity, kMaxSpeed);
    approach_m_per_s += next - rubbing_m_per_s;
    mean_velocity_m_per_s += next - rubbing_m_per_s;
    rubbing_m_per_s = next;
    normal_force_n = bounded(normal_force, kMaxForce);
  }

  /// Steps of a sample that a friction needs: its bristles on the body's mobility turn by 0.4 rad
  /// in one at most, if it has not more than eight. (A string bowed in steps four times as long
  /// takes twice the force that it should.)
  [[nodiscard]] double rubbing_steps(double sample_s) const noexcept {
    constexpr double kAngle = 0.4, kMaxSteps = 8;
    const double angle = std::sqrt(friction.law().stiffness_n_per_m * impulse_mobility) * sample_s;
    return std::min(angle / kAngle, kMaxSteps);
  }

  /// Begins a step of h seconds: `body_free` is the body's mean velocity at the place without the
  /// contacts' forces, `coupled` the place's
  /// mobility, m/(N s), without the exciter's own.
  [[gnu::always_inline]] void enter_step(ContactTerm& t, double body_free, double coupled,
                                         double h) noexcept {
    const bool strikes = kind == Kind::kImpact;
    t.may_be_negative = !strikes;
    t.own_mobility = strikes ? 0.5 * h * inverse_mass : 0;
    t.own_free_velocity =
        strikes ? velocity_m_per_s + t.own_mobility * external_force_n : rubbing_m_per_s;
    t.free = t.own_free_velocity - body_free;
    t.law = {};
    if (strikes) {
      if (Impact::in_contact(depth_m, approach_m_per_s, h))
        t.law = impact.enter_step(depth_m, approach_m_per_s, h);
    } else {
      const double rate = expected(t.free - coupled * last_force_n, mean_velocity_m_per_s);
      friction.enter_step(normal_force_n, rate, friction.law().roughness > 0 ? noise.normal() : 0.0,
                          h);
      t.law = friction.stage().plain();
    }
  }
  /// Friction's second stage, from what the first led to.
  [[gnu::always_inline]] void refine(ContactTerm& t) noexcept {
    friction.refine(t.mean);
    t.law = friction.stage().plain();
  }
  /// Ends it; `mean` and `force` of the term are those of the step.
  [[gnu::always_inline]] void leave_step(const ContactTerm& t, double h) noexcept {
    approach_m_per_s = extrapolate_velocity(t.mean, mean_velocity_m_per_s);
    mean_velocity_m_per_s = t.mean;
    impulse_ns += h * t.force;
    if (kind == Kind::kFriction) {
      const double stored = friction.stored_j();
      friction.pass_step(t.mean);
      last_force_n = t.force;
      dissipated_j += h * t.force * t.mean + (stored - friction.stored_j());
      return;
    }
    if (t.acts)
      impact.pass_step(t.mean, h);
    const double own_mean_velocity = t.own_free_velocity - t.own_mobility * t.force,
                 before = depth_m;
    position_m += h * own_mean_velocity;
    velocity_m_per_s = 2 * own_mean_velocity - velocity_m_per_s;
    depth_m += h * t.mean;
    impact.leave_step(depth_m);
    record_step(before, depth_m, t.force, h);
  }

  /// True where the energy in the contact is still what its steps were chosen for.
  [[nodiscard, gnu::always_inline]] bool level_valid(double energy_j) const noexcept {
    return energy_j <= 1.1 * level_energy_j && energy_j >= 0.5 * level_energy_j;
  }

  /// Books what a step of an impact was.
  [[gnu::always_inline]] void record_step(double before_m, double after_m, double force,
                                          double h) noexcept {
    if (before_m <= 0 && after_m <= 0)
      return;
    double time = h;
    if (before_m < 0 || after_m < 0) // only from, or up to, the passage through the surface
      time = h * (before_m > after_m ? before_m : after_m) / std::abs(after_m - before_m);
    ongoing.duration_s += time;
    ongoing.impulse_ns += h * force;
    ongoing.peak_n = force > ongoing.peak_n ? force : ongoing.peak_n;
    if (after_m <= 0) {
      last = ongoing;
      ongoing = {};
      ++impact_count;
    }
  }
  /// Books a contact far shorter than a step.
  [[gnu::always_inline]] void record_impulse(double impulse, double h) noexcept {
    last = {0, impulse, impulse / h};
    ongoing = {};
    ++impact_count;
  }
};

} // namespace tactus::contact

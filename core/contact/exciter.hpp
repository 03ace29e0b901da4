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

// Numbers from outside are clamped to these limits.
inline constexpr double kMaxForce = 1e7;    ///< N, external
inline constexpr double kMaxSpeed = 1e4;    ///< m/s
inline constexpr double kMaxDistance = 1e3; ///< m
inline constexpr double kMaxState = 1e60;   ///< N, m/s; beyond it the body is reset

/// Velocity at the end of a step, extrapolated from the means of this step and the one before.
[[nodiscard, gnu::always_inline]] inline double extrapolate_velocity(double mean,
                                                                     double mean_before) noexcept {
  return mean + 0.5 * (mean - mean_before);
}

/// Velocity at the start of a step in which the force may reverse the velocity (friction noise). It
/// is the average of two means: the mean velocity that the last step's force would give, and the
/// mean velocity of the step before.
[[nodiscard, gnu::always_inline]] inline double initial_velocity(double mean_with_last_force,
                                                                 double mean_before) noexcept {
  return 0.5 * (mean_with_last_force + mean_before);
}

/// Measures of one completed impact.
struct ImpactRecord {
  double duration_s = 0;
  double impulse_ns = 0;
  double peak_n = 0; ///< largest mean force of a step
};

/// One contact in the linear system of a step (ContactSystem). Velocities are means of the step, of
/// the exciter relative to the body, m/s.
struct ContactTerm {
  double own_free_velocity = 0; ///< free velocity of the exciter alone, without the contact's force
  double own_mobility = 0;      ///< mobility of the exciter alone, m/(N s)
  double free = 0;              ///< relative velocity without any contact's force
  LinearForce law;
  double force = 0, mean = 0;   ///< solution: N, m/s
  bool acts = false;            ///< has a force in this step
  bool may_be_negative = false; ///< friction may be negative, an impact may not

  /// Solves for one contact alone, with the mobility of body and exciter together.
  [[gnu::always_inline]] void solve(double mobility) noexcept {
    const double inverse_denominator = 1 / (1 + law.slope_ns_per_m * mobility);
    mean = (free - mobility * law.offset_n) * inverse_denominator;
    force = (law.offset_n + law.slope_ns_per_m * free) * inverse_denominator;
  }
};

/// The excitation of a body at one contact point: none, a mass that strikes it, or a surface that
/// rubs it.
struct Exciter {
  enum class Kind { kNone, kImpact, kFriction };
  Kind kind = Kind::kNone;

  // Impact: a free mass. Positions and velocities are positive into the body.
  Impact impact;
  double mass_kg = 0.01;
  bool held = false; ///< the velocity is prescribed, as for an infinite mass
  double position_m = -1, velocity_m_per_s = 0;
  double external_force_n = 0; ///< force on the mass, into the body; stays until it is changed
  /// True if the contact is too short for the finest steps; it is then an impulse with the exact
  /// restitution.
  bool impulsive = false;
  ImpactRecord ongoing, last;
  std::size_t impact_count = 0; ///< completed impacts

  // Friction: a surface with a prescribed velocity.
  Friction friction;
  double normal_force_n = 0, rubbing_m_per_s = 0;
  Random noise = Random();
  double last_force_n = 0; ///< force of the last step

  // Both kinds.
  double depth_m = 0;               ///< penetration; unused by friction
  double approach_m_per_s = 0;      ///< rate of the penetration; for friction, the relative
                                    ///< velocity
  double mean_velocity_m_per_s = 0; ///< relative velocity in the last step
  double force_n = 0;               ///< mean force of the last sample
  double impulse_ns = 0;            ///< impulse of the current sample so far
  double dissipated_j = 0;          ///< energy dissipated by friction in the last sample
  bool near = false;                ///< takes part in the steps of this sample
  bool depth_valid = false;         ///< depth and approach are up to date from the steps before
  std::size_t level = 0;            ///< 2^level steps per sample are fine enough for this contact

  // Mobility and mass at the contact point, of the body together with the exciter's own mass.
  std::array<double, kLevels> mobility{}; ///< mean velocity of a step per force, m/(N s), by level
  double impulse_mobility = 0;            ///< change of velocity per impulse, 1/kg
  double inverse_mass = 100;              ///< 1/mass_kg; 0 if held or friction
  double effective_mass_kg = 0.01;        ///< 1/impulse_mobility
  double level_energy_j = -1;             ///< energy of the contact for which `level` was chosen

  /// Kinetic energy of a free mass and energy stored in the contact, J.
  [[nodiscard]] double energy() const noexcept {
    if (kind == Kind::kImpact)
      return (held ? 0.0 : 0.5 * mass_kg * velocity_m_per_s * velocity_m_per_s) +
             impact.stored_j() + impact.energy_account_j();
    return kind == Kind::kFriction ? friction.stored_j() : 0.0;
  }

  /// Prescribes the velocity of a held striker, into the body.
  void move_at(double velocity) noexcept {
    const double next = bounded(velocity, kMaxSpeed);
    approach_m_per_s += next - velocity_m_per_s;
    mean_velocity_m_per_s += next - velocity_m_per_s;
    velocity_m_per_s = next;
  }
  /// Prescribes the normal force, N, and the velocity, m/s, of a rubbing surface.
  void rub(double normal_force, double velocity) noexcept {
    const double next = bounded(velocity, kMaxSpeed);
    approach_m_per_s += next - rubbing_m_per_s;
    mean_velocity_m_per_s += next - rubbing_m_per_s;
    rubbing_m_per_s = next;
    normal_force_n = bounded(normal_force, kMaxForce);
  }

  /// Number of steps per sample that friction needs, at most eight. In one step the oscillation of
  /// the bristles against the body's impulse mobility, sqrt(sigma0 Y), may advance by 0.4 rad. (In
  /// steps four times as long, a bowed string needs twice the correct normal force.)
  [[nodiscard]] double rubbing_steps(double sample_s) const noexcept {
    constexpr double kAngle = 0.4, kMaxSteps = 8;
    const double angle = std::sqrt(friction.law().stiffness_n_per_m * impulse_mobility) * sample_s;
    return std::min(angle / kAngle, kMaxSteps);
  }

  /// Begins a step of h seconds. `body_free`, m/s: mean velocity of the body at the contact point
  /// without the contacts' forces. `coupled`, m/(N s): the body's mobility at this point, without
  /// the exciter's own mobility.
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
      const double rate = initial_velocity(t.free - coupled * last_force_n, mean_velocity_m_per_s);
      friction.enter_step(normal_force_n, rate, friction.law().roughness > 0 ? noise.normal() : 0.0,
                          h);
      t.law = friction.stage().unscaled();
    }
  }
  /// Second stage of friction, from the solution of the first stage.
  [[gnu::always_inline]] void refine(ContactTerm& t) noexcept {
    friction.refine(t.mean);
    t.law = friction.stage().unscaled();
  }
  /// Ends a step of h seconds; `mean` and `force` of the term are its solution.
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

  /// True if `level` still fits the energy of the contact.
  [[nodiscard, gnu::always_inline]] bool level_valid(double energy_j) const noexcept {
    return energy_j <= 1.1 * level_energy_j && energy_j >= 0.5 * level_energy_j;
  }

  /// Adds a step of an impact to the record, from the depths before and after it.
  [[gnu::always_inline]] void record_step(double before_m, double after_m, double force,
                                          double h) noexcept {
    if (before_m <= 0 && after_m <= 0)
      return;
    double time = h;
    if (before_m < 0 || after_m < 0) // only the part of the step below the surface counts
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
  /// Records an impact that is far shorter than a step.
  [[gnu::always_inline]] void record_impulse(double impulse, double h) noexcept {
    last = {0, impulse, impulse / h};
    ongoing = {};
    ++impact_count;
  }
};

} // namespace tactus::contact

#pragma once

#include "core/contact/power.hpp"
#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tactus::contact {

struct PressedBlock;

/// The force of a contact during one step, linear in the mean relative velocity v of the step:
/// F = offset + slope v, slope >= 0. v is counted positive into the body.
struct LinearForce {
  double offset_n = 0;
  double slope_ns_per_m = 0;
};

/// Force between two bodies that touch:
///     F = k d^a (1 + mu x') for an indentation d > 0, else 0; never negative.
/// [k] = N/m^a, [mu] = s/m. Hunt & Crossley 1975, eq. 15. a = 3/2 is Hertz' contact of round
/// bodies, a = 1 a spring. Without a compliance the penetration x is the indentation d. With a
/// compliance C in series (static compliance of the modes that the body omits) x = d + C k d^a. Not
/// valid for adhesion.
struct ImpactLaw {
  double stiffness = 1e7;           ///< k
  double exponent = 1.5;            ///< a, 1..6
  double dissipation_s_per_m = 0.3; ///< mu
  double compliance_m_per_n = 0;    ///< C >= 0

  /// The law with every number finite and clamped to the range in which the scheme is tested.
  [[nodiscard]] ImpactLaw within_range() const noexcept;
  /// Force, N.
  [[nodiscard]] double force(double penetration_m, double velocity_m_per_s) const noexcept;
  /// Penetration under a constant force, m: d + C F.
  [[nodiscard]] double penetration(double force_n) const noexcept {
    return force_n > 0 ? math::pow(force_n / stiffness, 1 / exponent) + compliance_m_per_n * force_n
                       : 0.0;
  }
  /// Work stored by an elastic penetration, J: k d^(a+1)/(a+1) + C F^2/2.
  [[nodiscard]] double work(double penetration_m) const noexcept;
  /// The part d of a penetration, m.
  [[nodiscard]] double indentation(double penetration_m) const noexcept;
  /// Penetration that stores this work, m: the maximum in a lossless impact with this energy.
  [[nodiscard]] double deepest(double work_j) const noexcept;
  /// Contact time of a lossless impact of this reduced mass, s, for C = 0:
  /// sqrt(pi) Gamma(1 + b)/Gamma(1/2 + b) 2 x_max/v, b = 1/(a + 1), x_max = deepest(m v^2/2).
  /// (2.9432 x_max/v for a = 3/2, half a period for a = 1.)
  [[nodiscard]] double duration(double mass_kg, double speed_m_per_s) const noexcept;
};

/// Hertz' stiffness of a sphere against a flat body, N/m^(3/2): k = 4/3 E* sqrt(R),
/// 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
[[nodiscard]] double hertz_stiffness(double radius_m, double modulus_pa, double poisson,
                                     double other_modulus_pa, double other_poisson) noexcept;

/// Coefficient of restitution e = speed after / speed before of a free body that hits a rigid wall
/// under ImpactLaw. It depends on y = mu v >= 0 only: y - ln(1 + y) has the same value before the
/// contact (y) and after it (-e y), for any k, a and mass (Marhefka & Orin 1999). With Lambert's
/// W0, e = (1 + W0(-exp(-1 - y + ln(1 + y))))/y. Relative error below 1e-9.
[[nodiscard]] double restitution(double mu_times_speed) noexcept;

/// Inverse of restitution(): dissipation mu, s/m, for which an impact at this speed has restitution
/// e in (0, 1]. mu grows without bound as e goes to 0; e below 0.01 counts as 0.01.
[[nodiscard]] double dissipation_for(double restitution, double speed_m_per_s) noexcept;

/// One contact under ImpactLaw, advanced in time steps by the energy-quadratised, linearly implicit
/// scheme (Lopes, Helie & Falaize 2015; Ducceschi & Bilbao 2019).
///
/// The stored work is written as psi^2/2, and psi is stepped with the chain rule,
///     psi' = gamma(x) x',   gamma = sqrt(k (a+1)/2) x^((a-1)/2),   F = gamma psi + k mu x^a x',
/// with gamma and x^a at the predicted middle of the step, x + h x'/2. F is then linear in the mean
/// velocity v of the step. The energy balance of a step is exact: the work F v h taken from the
/// bodies equals the growth of psi^2/2 plus the loss k mu x^a v^2 h. So no parameter and no step
/// length can create energy.
///
/// psi drifts from the exact psi*(x) = sqrt(2 k x^(a+1)/(a+1)) by the error of the step. After each
/// step psi is set to psi*. The energy that this frees or takes is booked in an account that never
/// falls below zero (`energy_account_j`): the sum of stored energy and account is unchanged, and
/// the rebound does not depend on the drift.
///
/// In the step in which a contact begins, gamma is the slope of psi*'s chord over the predicted
/// travel of the step. psi then ends at psi*(x), regardless of when within the step the mass met
/// the surface. In the step in which a contact ends, gamma is the slope of the chord from psi to 0,
/// so that all stored energy is returned. The loss of these two steps is mu times the work over the
/// same travel.
class Impact {
public:
  Impact() noexcept { set({}); }
  void set(const ImpactLaw& law) noexcept;
  [[nodiscard]] const ImpactLaw& law() const noexcept { return law_; }
  /// No contact, nothing stored.
  void release() noexcept {
    psi_ = energy_account_j_ = 0;
    touching_ = false;
  }

  /// Starts in contact at this penetration, with the work of an elastic penetration stored.
  void hold(double penetration_m) noexcept {
    release();
    touching_ = penetration_m > 0;
    psi_ = std::sqrt(2 * law_.work(penetration_m));
  }

  /// True if a step of h seconds from penetration x (m) at this rate (m/s) has contact.
  [[nodiscard, gnu::always_inline]] static bool in_contact(double x, double rate,
                                                           double h) noexcept {
    return x > 0 || x + h * rate > kTouch;
  }
  /// The force law of a step with contact. If the force that follows from it is negative, the step
  /// has no force and pass_step() must not be called. `has_compliance` false asserts that the law
  /// has no compliance: all values then stay in registers.
  template <bool has_compliance = true>
  [[nodiscard, gnu::always_inline]] LinearForce enter_step(double x, double rate,
                                                           double h) noexcept {
    if (!touching_) {
      touching_ = true;
      energy_account_j_ = 0;
    }
    const double travel = h * rate, end = x + travel;
    if constexpr (has_compliance)
      if (compliant())
        return enter_compliant_step(x, travel, h);
    if (x > 0 && end > 0) {
      const double depth = within_reach(x + 0.5 * travel);
      const double power = power_(depth); // x^((a-1)/2)
      gamma_ = gamma_scale_ * power;
      const double slope = 0.5 * h * gamma_ * gamma_ + loss_scale_ * depth * power * power;
      return {gamma_ * psi_, slope};
    }
    if (x <= 0) {
      const double depth = within_reach(end);
      return begin_contact(psi_scale_ * depth * power_(depth), travel, h);
    }
    return end_contact(travel, h);
  }
  /// To be called after enter_step() if the force is not negative. `mean_velocity`: of the step,
  /// into the body.
  [[gnu::always_inline]] void pass_step(double mean_velocity, double h) noexcept {
    psi_ += gamma_ * h * mean_velocity;
  }
  /// To be called after every step, with or without contact. x: penetration at the end of the step,
  /// m.
  template <bool has_compliance = true> [[gnu::always_inline]] void leave_step(double x) noexcept {
    if (x <= 0) {
      energy_account_j_ += 0.5 * psi_ * psi_;
      psi_ = 0;
      touching_ = false;
      return;
    }
    const double depth = within_reach(x);
    double target_psi = 0;
    if (has_compliance && compliant())
      target_psi = relax(depth).psi;
    else
      target_psi = psi_scale_ * depth * power_(depth);
    const double energy_error = 0.5 * (target_psi * target_psi - psi_ * psi_);
    if (energy_error <= energy_account_j_) {
      energy_account_j_ -= energy_error;
      psi_ = target_psi;
    } else {
      psi_ = std::sqrt(psi_ * psi_ + 2 * energy_account_j_);
      energy_account_j_ = 0;
    }
  }

  [[nodiscard]] bool touching() const noexcept { return touching_; }
  /// True if a compliance is in series with the law.
  [[nodiscard]] bool compliant() const noexcept { return law_.compliance_m_per_n > 0; }
  /// Energy stored elastically, J.
  [[nodiscard]] double stored_j() const noexcept { return 0.5 * psi_ * psi_; }
  /// Energy in the account, J.
  [[nodiscard]] double energy_account_j() const noexcept { return energy_account_j_; }
  /// Square of the largest angular frequency, 1/s^2, of a mass on this contact: a k x^(a-1)/m at
  /// the deepest penetration x that the energy allows. It determines how fine the steps must be.
  [[nodiscard, gnu::always_inline]] double stiffest(double energy_j,
                                                    double mass_kg) const noexcept {
    double stiffness = rate_scale_;
    if (energy_j > 1e-200)
      stiffness *= rate_power_(energy_j);
    else if (law_.exponent > 1)
      stiffness = 0;
    return stiffness / ((1 + stiffness * law_.compliance_m_per_n) * mass_kg);
  }

  static constexpr double kMinDepth = 1e-100, kMaxDepth = 1e3; ///< m; powers are taken within these
  /// Copies the state and the coefficients of a contact without compliance into a lane of a block,
  /// and the state back.
  void store_to_lane(PressedBlock& block, std::size_t lane) const noexcept;
  void load_from_lane(const PressedBlock& block, std::size_t lane) noexcept;

private:
  static constexpr double kTouch = 1e-60; ///< m
  /// Keeps the powers from becoming denormal or infinite. The energy balance holds for any depth.
  [[nodiscard, gnu::always_inline]] static double within_reach(double x) noexcept {
    return x < kMinDepth ? kMinDepth : (x > kMaxDepth ? kMaxDepth : x);
  }

  /// The contact begins within the step; `end_psi` is psi* at the end of the predicted travel.
  [[nodiscard, gnu::always_inline]] LinearForce begin_contact(double end_psi, double travel,
                                                              double h) noexcept {
    gamma_ = end_psi / travel;
    return chord(0.5 * end_psi * end_psi, travel, h);
  }
  /// The contact ends within the step, and all stored energy is returned.
  [[nodiscard, gnu::always_inline]] LinearForce end_contact(double travel, double h) noexcept {
    const double stored = 0.5 * psi_ * psi_ + energy_account_j_;
    energy_account_j_ = 0;
    psi_ = std::sqrt(2 * stored);
    gamma_ = psi_ / -travel;
    return chord(stored, travel, h);
  }
  [[nodiscard, gnu::always_inline]] LinearForce chord(double work_j, double travel,
                                                      double h) const noexcept {
    return {gamma_ * psi_,
            0.5 * h * gamma_ * gamma_ + law_.dissipation_s_per_m * work_j / std::abs(travel)};
  }
  /// With a compliance in series: elastic force and psi* at a penetration.
  struct ElasticState {
    double force_n, psi;
  };
  [[nodiscard]] ElasticState relax(double penetration) noexcept;
  [[nodiscard]] LinearForce enter_compliant_step(double x, double travel, double h) noexcept;

  double psi_ = 0, energy_account_j_ = 0, gamma_ = 0;
  double indentation_ = 0; ///< last result of relax(), m: where Newton's method starts
  bool touching_ = false;
  TaylorPower power_{0.25};
  double gamma_scale_ = 0, psi_scale_ = 0, loss_scale_ = 0;
  Power rate_power_{0.2};
  double rate_scale_ = 0;
  ImpactLaw law_;
};

} // namespace tactus::contact

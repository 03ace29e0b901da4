#pragma once

#include "core/contact/impact.hpp"
#include "core/contact/power.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace tactus::contact {

/// Parameters of elasto-plastic bristle friction (Dupont, Hayward, Armstrong & Altpeter 2002; for
/// sound: Avanzini, Serafin & Rocchesso 2005). The mean bend z (m) of the bristles between two
/// surfaces that slide at the relative velocity v (m/s) under the normal force F_n (N) obeys
///     z' = v (1 - alpha(z, v) z / z_ss(v)),   f = sigma0 z + sigma1 z' + sigma2 v
///     z_ss = sgn(v) F_n (mu_d + (mu_s - mu_d) exp(-(v/v_s)^2)) / sigma0      bend when sliding
/// f is the friction force (N). alpha = 0 while the bristles only bend, |z| < z_ba = kappa mu_d F_n
/// / sigma0, or spring back (z v < 0). alpha = 1 for |z| >= |z_ss|. Between z_ba and |z_ss|, alpha
/// follows half a period of a sine.
struct FrictionLaw {
  double static_coefficient = 0.8;  ///< mu_s >= mu_d
  double dynamic_coefficient = 0.3; ///< mu_d
  double stribeck_m_per_s = 0.1;    ///< v_s: sliding speed above which friction falls to mu_d
  double breakaway = 0.5;           ///< kappa, in (0, 1): purely elastic share of mu_d F_n
  double stiffness_n_per_m = 1e5;   ///< sigma0
  double damping_ns_per_m = 40;     ///< sigma1
  double viscosity_ns_per_m = 0.5;  ///< sigma2
  /// sigma3, N^(1/2) s^(1/2)/m^(1/2): adds a random force sigma3 |w| sqrt(F_n |v|) against the
  /// motion, w a normal random number. It acts as a random viscosity, so it only dissipates.
  double roughness = 0;

  /// The law with every number finite and clamped to the range in which the scheme is tested.
  [[nodiscard]] FrictionLaw within_range() const noexcept;
};

/// A LinearForce multiplied by a positive scale: scale F = offset + slope v.
struct ScaledForce {
  double offset = 0, slope = 0, scale = 1;
  [[nodiscard, gnu::always_inline]] LinearForce unscaled() const noexcept {
    return {offset / scale, slope / scale};
  }
};

/// One rubbing contact under FrictionLaw, advanced in time steps: linearly implicit in two stages,
/// no iteration.
///
/// With a = alpha |v|/|z_ss| taken from the stage before, z' = v - a z and f are linear in the mean
/// velocity v of the step; z is its mean over the step. The step then dissipates
///     f v - sigma0 z z' = sigma0 a z^2 + (sigma1 + sigma2) v^2 - sigma1 a z v,
/// which is never negative if sigma1^2 a <= 4 sigma0 (sigma1 + sigma2). Fast sliding violates this
/// in the model itself. So sigma1 is limited to the largest passive value,
///     sigma1 <= (2 sigma0/a) (1 + sqrt(1 + a sigma2/sigma0)).
///
/// A step is enter_step(), then refine() with the mean velocity under the first stage's force, then
/// pass_step() with the mean velocity under the second stage's force.
class Friction {
public:
  Friction() noexcept { set({}); }
  void set(const FrictionLaw& law) noexcept;
  [[nodiscard]] const FrictionLaw& law() const noexcept { return law_; }
  void release() noexcept {
    bend_ = slip_ = steady_bend_ = bristle_impedance_ = viscosity_ = 0;
    scale_ = 1;
    pressed_ = false;
  }

  /// Begins a step of h seconds and computes its first stage. `velocity`, m/s: of the rubbing
  /// surface relative to the body, at the start of the step. `noise`: a normal random number.
  [[gnu::always_inline]] void enter_step(double normal_force_n, double velocity, double noise,
                                         double h) noexcept {
    h_ = h;
    if (!(normal_force_n > kMinNormalForce)) {
      release();
      return;
    }
    pressed_ = true;
    slide_ = normal_force_n * dynamic_over_stiffness_;
    stick_ = normal_force_n * excess_over_stiffness_;
    viscosity_ = law_.viscosity_ns_per_m;
    if (law_.roughness > 0)
      viscosity_ += law_.roughness * std::abs(noise) *
                    std::sqrt(normal_force_n / (std::abs(velocity) + kMinSpeed));
    linearise<true>(velocity, bend_ + 0.5 * h * velocity);
  }
  /// The force law of the current stage.
  [[nodiscard, gnu::always_inline]] ScaledForce stage() const noexcept {
    if (!pressed_)
      return {};
    return {(scale_ * law_.stiffness_n_per_m - bristle_impedance_ * slip_) * bend_,
            bristle_impedance_ * steady_bend_ + scale_ * viscosity_, scale_};
  }
  /// Mean velocity of the step under this stage's force, m/s, from the mean velocity without force
  /// and the mobility of the contact point, m/(N s). Takes fewer operations than a solution by
  /// stage().
  [[nodiscard, gnu::always_inline]] double mean(double free, double mobility) const noexcept {
    return (scale_ * (free - mobility * law_.stiffness_n_per_m * bend_) +
            mobility * bristle_impedance_ * (slip_ * bend_)) *
           inverse_denominator(mobility);
  }
  /// Friction force at the velocity mean(), N.
  [[nodiscard, gnu::always_inline]] double force(double free, double mobility) const noexcept {
    const ScaledForce f = stage();
    return (f.offset + f.slope * free) * inverse_denominator(mobility);
  }
  /// Computes the second stage from the mean velocity under the force of the first stage.
  [[gnu::always_inline]] void refine(double mean_velocity) noexcept {
    if (pressed_)
      linearise<false>(mean_velocity, bend_ + 0.5 * h_ * bend_rate(mean_velocity));
  }
  /// Ends the step with its mean velocity.
  [[gnu::always_inline]] void pass_step(double mean_velocity) noexcept {
    if (pressed_)
      bend_ += h_ * bend_rate(mean_velocity);
  }

  [[nodiscard]] double bend_m() const noexcept { return bend_; }
  /// Energy of the bent bristles, J.
  [[nodiscard]] double stored_j() const noexcept {
    return 0.5 * law_.stiffness_n_per_m * bend_ * bend_;
  }

private:
  [[nodiscard, gnu::always_inline]] double inverse_denominator(double mobility) const noexcept {
    return 1 /
           (scale_ * (1 + mobility * viscosity_) + mobility * bristle_impedance_ * steady_bend_);
  }
  /// 2^-y for y >= 0, relative error below 1e-8.
  [[nodiscard, gnu::always_inline]] static double gaussian(double y) noexcept {
    constexpr double kRound = 0x1.8p52;
    y = y > 1000 ? 1000 : y;
    const double shifted = kRound - y, t = (kRound - shifted) - y; // |t| <= 1/2
    const double scale = std::bit_cast<double>((std::bit_cast<std::uint64_t>(shifted) << 52) +
                                               std::bit_cast<std::uint64_t>(1.0));
    const double t2 = t * t;
    return scale * (((1 + t * 6.9314718055994531e-1) +
                     t2 * (2.4022650695910072e-1 + t * 5.5504108664821580e-2)) +
                    (t2 * t2) * ((9.6181291076284772e-3 + t * 1.3333558146428443e-3) +
                                 t2 * (1.5403530393381609e-4 + t * 1.5252733804059840e-5)));
  }
  static constexpr double kMinNormalForce = 1e-12; ///< N; no friction below it
  static constexpr double kTangentReach = 0.2;     ///< largest change of ratio_ for which the
                                                   ///< tangent is used
  static constexpr double kUnsetRatio = 1e300;     ///< ratio_ before the first evaluation
  static constexpr double kMinSpeed =
      1e-4; ///< m/s; bounds the viscosity of a rough contact at rest

  /// Evaluates the nonlinear terms at a velocity v and a bend z. All terms of the step are
  /// multiplied by scale = |z_ss| (1 + a h/2), which avoids a chain of divisions. The first stage
  /// may be approximate: it uses the tangent of exp(-(v/v_s)^2) at its last evaluation.
  template <bool first> [[gnu::always_inline]] void linearise(double v, double z) noexcept {
    const double ratio = v * inverse_stribeck_,
                 ratio_change = ratio - ratio_; // 2^-ratio^2 = e^-(v/v_s)^2
    const double bend = std::abs(z), elastic = law_.breakaway * slide_, speed = std::abs(v);
    steady_bend_ = slide_ + stick_ * (gaussian_ + tangent_ * v); // |z_ss|
    if (!first || !(std::abs(ratio_change) < kTangentReach)) {
      const double bell = gaussian(ratio * ratio);
      ratio_ = ratio;
      tangent_ = -2 * std::numbers::ln2 * ratio * inverse_stribeck_ * bell;
      gaussian_ = bell - tangent_ * v;
      steady_bend_ = slide_ + stick_ * bell;
    }
    slip_ = 0;
    double s1 = law_.damping_ns_per_m;
    const double s0 = law_.stiffness_n_per_m;
    if (v * z > 0 && bend > elastic) {
      slip_ = speed;
      if (bend < steady_bend_)
        slip_ *= 0.5 + 0.5 * half_sine((bend - 0.5 * (steady_bend_ + elastic)) /
                                       (steady_bend_ - elastic));
      if (s1 * s1 * slip_ > 4 * s0 * (s1 + viscosity_) * steady_bend_) {
        const double slack = s0 * steady_bend_ / slip_; // sigma0/a
        s1 = 2 * (slack + std::sqrt(slack * (slack + viscosity_)));
      }
    }
    scale_ = steady_bend_ + 0.5 * h_ * slip_;
    bristle_impedance_ = 0.5 * h_ * s0 + s1;
  }
  /// z' of the step.
  [[nodiscard, gnu::always_inline]] double bend_rate(double mean_velocity) const noexcept {
    return (mean_velocity * steady_bend_ - slip_ * bend_) / scale_;
  }
  /// sin(pi x) for |x| <= 1/2, error below 1e-7.
  [[nodiscard, gnu::always_inline]] static double half_sine(double x) noexcept {
    const double t = std::numbers::pi * x, t2 = t * t, t4 = t2 * t2;
    return t * (((1 - t2 * (1.0 / 6)) + t4 * (1.0 / 120 - t2 * (1.0 / 5040))) +
                (t4 * t4) * (1.0 / 362880 - t2 * (1.0 / 39916800)));
  }

  double bend_ = 0;              ///< z, m
  double h_ = 0;                 ///< length of the step, s
  double slide_ = 0;             ///< mu_d F_n/sigma0, m
  double stick_ = 0;             ///< (mu_s - mu_d) F_n/sigma0, m
  double viscosity_ = 0;         ///< sigma2 with the random part, N s/m
  double steady_bend_ = 1;       ///< |z_ss|, m
  double slip_ = 0;              ///< alpha |v| = a |z_ss|, m/s
  double scale_ = 1;             ///< |z_ss| (1 + a h/2), m
  double bristle_impedance_ = 0; ///< sigma0 h/2 + sigma1, N s/m
  /// exp(-(v/v_s)^2) near its last evaluation is gaussian_ + tangent_ v. ratio_ is v sqrt(log2 e)
  /// /v_s of that evaluation.
  double ratio_ = kUnsetRatio, gaussian_ = 1, tangent_ = 0;
  bool pressed_ = false;
  double dynamic_over_stiffness_ = 0, excess_over_stiffness_ = 0, inverse_stribeck_ = 0;
  FrictionLaw law_;
};

} // namespace tactus::contact

#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::modal {

/// Force between two bodies that touch: f = k d^a (1 + mu d') for a compression d > 0, never
/// negative. [k] = N/m^a, [mu] = s/m. Hunt & Crossley 1975, eq. 15; a = 3/2 is Hertz' contact of
/// round bodies. Not valid for adhesion.
struct ContactLaw {
  double stiffness = 1e9;
  double exponent = 1.5;
  double loss_s_per_m = 0;

  [[nodiscard]] double force(double compression_m, double speed_m_per_s) const noexcept {
    if (!(compression_m > 0))
      return 0;
    const double elastic = stiffness * power(compression_m);
    return std::max(elastic * (1 + loss_s_per_m * speed_m_per_s), 0.0);
  }
  /// Work that an elastic compression stores, J.
  [[nodiscard]] double work(double compression_m) const noexcept {
    if (!(compression_m > 0))
      return 0;
    return stiffness / (exponent + 1) * compression_m * power(compression_m);
  }
  /// d force / d compression of the elastic part, N/m.
  [[nodiscard]] double slope(double compression_m) const noexcept {
    if (!(compression_m > 0))
      return 0;
    return exponent * stiffness *
           (exponent == 1.5 ? std::sqrt(compression_m)
            : exponent == 1 ? 1.0
                            : std::pow(compression_m, exponent - 1));
  }
  /// d^a; quick for balls and springs.
  [[nodiscard]] double power(double compression_m) const noexcept {
    return exponent == 1.5 ? compression_m * std::sqrt(compression_m)
           : exponent == 1 ? compression_m
                           : std::pow(compression_m, exponent);
  }
  /// Deepest compression and duration of an impact of this reduced mass, without loss: from
  /// m v^2/2 = k d^(a+1)/(a+1), and the time integral of its motion (2.9432 d/v for a = 3/2).
  [[nodiscard]] double deepest(double mass_kg, double speed_m_per_s) const noexcept {
    return std::pow((exponent + 1) * mass_kg * speed_m_per_s * speed_m_per_s / (2 * stiffness),
                    1 / (exponent + 1));
  }
  [[nodiscard]] double duration(double mass_kg, double speed_m_per_s) const noexcept {
    const double b = 1 / (exponent + 1);
    const double integral = std::sqrt(std::numbers::pi) * std::tgamma(1 + b) / std::tgamma(0.5 + b);
    return 2 * deepest(mass_kg, speed_m_per_s) / speed_m_per_s * integral;
  }
};

/// Hertz' stiffness of a ball against a flat body: k = 4/3 E* sqrt(R),
/// 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
[[nodiscard]] inline double hertz_stiffness(double radius_m, double modulus_pa, double poisson,
                                            double other_modulus_pa,
                                            double other_poisson) noexcept {
  const double softness =
      (1 - poisson * poisson) / modulus_pa + (1 - other_poisson * other_poisson) / other_modulus_pa;
  return 4.0 / 3.0 * std::sqrt(radius_m) / softness;
}

/// The loss mu with which an impact at speed v on a resting wall returns with e v:
/// ln((1 + mu v) / (1 - mu e v)) = mu v (1 + e), exact for the law above with any exponent
/// (Marhefka & Orin 1999). e in (0, 1]; grows without bound as e goes to 0, where it is cut off.
[[nodiscard]] inline double loss_for_restitution(double restitution,
                                                 double speed_m_per_s) noexcept {
  if (restitution >= 1)
    return 0;
  const double e = std::max(restitution, 0.01);
  // x = mu v lies between 0 and 1/e; the difference of both sides changes sign once in between.
  double low = 1e-9, high = (1 - 1e-12) / e;
  for (int i = 0; i < 100; ++i) {
    const double x = 0.5 * (low + high);
    (std::log((1 + x) / (1 - e * x)) < x * (1 + e) ? low : high) = x;
  }
  return 0.5 * (low + high) / speed_m_per_s;
}

} // namespace tactus::modal

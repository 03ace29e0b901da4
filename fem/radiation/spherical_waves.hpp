#pragma once
#include "fem/radiation/exterior_field.hpp"

namespace tactus::fem {

/// j_0(x) ... j_highest(x), by downward recursion (Miller).
[[nodiscard]] std::vector<double> spherical_bessel(std::size_t highest, double x);
/// h_0(x) ... h_highest(x) of the second kind, j - j y: outgoing for exp(+j omega t).
[[nodiscard]] std::vector<Complex> spherical_hankel(std::size_t highest, double x);
/// Regular waves psi_lm = j_l(k r) Y_lm(direction) at a point and their slopes n . grad psi_lm, at
/// [l^2 + l + m] for l up to a highest degree. Y_lm is complex and orthonormal with Condon and
/// Shortley's phase, polar axis z. The roots of the recurrences are tabulated:
///   cos Y_lm = A_lm Y_l-1,m + A_l+1,m Y_l+1,m,   A_lm = sqrt((l^2 - m^2)/(4 l^2 - 1)),
///   (d/dx + j d/dy) psi_lm = k (B_l+1,m+1 psi_l+1,m+1 + B_l,-m psi_l-1,m+1),
///   d/dz psi_lm = k (A_lm psi_l-1,m - A_l+1,m psi_l+1,m),
///   B_lm = sqrt((l + m)(l + m - 1)/(4 l^2 - 1)).
class RegularWaves {
public:
  explicit RegularWaves(std::size_t highest);
  /// Fills psi (no unit) and slope (1/m), (highest + 1)^2 values each, at `x` in m from the centre;
  /// k in 1/m, n of length 1.
  void evaluate(double k, const Vector3& x, const Vector3& n, std::span<Complex> psi,
                std::span<Complex> slope);

private:
  void evaluate_values(double k, const Vector3& x);
  // Tables begin a row at l = 0; values at l = -1, and their rows at m = -1.
  [[nodiscard]] std::size_t along(long l, long m) const noexcept {
    return static_cast<std::size_t>(m) * width_ + static_cast<std::size_t>(l);
  }
  [[nodiscard]] std::size_t across(long l, long m) const noexcept {
    return static_cast<std::size_t>(m + static_cast<long>(highest_) + 1) * width_ +
           static_cast<std::size_t>(l);
  }
  [[nodiscard]] std::size_t row(long m) const noexcept {
    return static_cast<std::size_t>(m + 1) * width_;
  }

  std::size_t highest_, width_;
  std::vector<double> along_, across_;   ///< A_lm for m >= 0, B_lm
  std::vector<double> real_, imaginary_; ///< psi_lm up to highest + 1, for m >= -1
};

/// Outgoing waves about `centre` of the field of each column of mu (unknowns() numbers a column):
///   p = sum c_lm h_l(k r)/h_l(k r_ref) Y_lm for r beyond the surface; exact term by term, from
///   G = -j k sum h_l(k r) j_l(k r') Y_lm Y'*_lm.
[[nodiscard]] std::vector<Complex> multipoles(const ExteriorField&, double k,
                                              std::span<const Complex> mu, std::size_t highest,
                                              const Vector3& centre, double reference_radius);

/// Mean power of outgoing waves, W: sum |c_lm / h_l(k r_ref)|^2 / (2 rho c k^2).
[[nodiscard]] double radiated_power(std::span<const Complex> coefficients, double k,
                                    double reference_radius, double air_density,
                                    double sound_speed);

} // namespace tactus::fem

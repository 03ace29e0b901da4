#pragma once
#include "fem/radiation/exterior_field.hpp"

namespace tactus::fem {

/// j_0(x) ... j_highest(x), by downward recursion (Miller).
[[nodiscard]] std::vector<double> spherical_bessel(std::size_t highest, double x);
/// h_0(x) ... h_highest(x) of the second kind, j - j y: outgoing for exp(+j omega t).
[[nodiscard]] std::vector<Complex> spherical_hankel(std::size_t highest, double x);
/// psi_lm = j_l(k r) Y_lm(direction) at [l^2 + l + m], Y_lm complex and orthonormal with Condon and
/// Shortley's phase, polar axis z.
[[nodiscard]] std::vector<Complex> regular_waves(std::size_t highest, double k, const Vector3& x);
/// n . grad psi_lm for l up to `highest`, from psi up to highest + 1.
[[nodiscard]] std::vector<Complex> regular_slopes(std::size_t highest, double k,
                                                  std::span<const Complex> psi, const Vector3& n);

/// Outgoing waves about `centre` of a field's layer mu (one column):
///   p = sum c_lm h_l(k r)/h_l(k r_ref) Y_lm for r beyond the surface; exact term by term, from
///   G = -j k sum h_l(k r) j_l(k r') Y_lm Y'*_lm.
[[nodiscard]] std::vector<Complex> multipoles(const ExteriorField&, double k,
                                              std::span<const Complex> mu, std::size_t columns,
                                              std::size_t highest, const Vector3& centre,
                                              double reference_radius);

/// Mean power of outgoing waves, W: sum |c_lm / h_l(k r_ref)|^2 / (2 rho c k^2).
[[nodiscard]] double radiated_power(std::span<const Complex> coefficients, double k,
                                    double reference_radius, double air_density,
                                    double sound_speed);

} // namespace tactus::fem

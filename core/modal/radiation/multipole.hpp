#pragma once

#include "core/modal/radiation/radiation.hpp"

#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace tactus::modal {

/// Spherical Hankel functions of the second kind h_l(x), l = 0 ... max_degree, by upward recursion,
/// which is stable for functions that grow with the degree.
[[nodiscard]] std::vector<std::complex<double>> spherical_hankel(std::size_t max_degree, double x);

/// A table's multipoles seen in one direction from their centre.
class MultipoleDirection {
public:
  MultipoleDirection(const ModalTable& table, const Vec3& direction);
  /// sum over m of c_lm Y_lm(direction) for each degree l of a mode, at a ratio of frequency,
  /// interpolated between the table's ratios.
  [[nodiscard]] std::vector<std::complex<double>> sums(std::size_t mode, double ratio) const;
  /// The same at one of the band's frequencies.
  [[nodiscard]] std::vector<std::complex<double>> band_sums(std::size_t mode,
                                                            std::size_t frequency) const;

private:
  [[nodiscard]] std::complex<double> harmonic(std::size_t l, std::size_t j) const noexcept;

  const MultipoleTable* poles_;
  std::vector<double> legendre_;
  double azimuth_ = 0;
};

/// Six degrees of freedom of a free body as a source of sound: three translations, each as a rigid
/// sphere of the same dipole moment.
struct RigidDipole {
  Vec3 axis{};         ///< principal axis, of length 1
  double radius_m = 0; ///< of a sphere that radiates alike along it; 0: silent
};
/// A body with an ellipsoid's mass and inertia and the volume of its surface, in incompressible
/// air: dipole moment rho (V + V_e k) a with Lamb's inertia coefficients k (Lamb 1932, section
/// 114), V_e the ellipsoid's volume, as much as a sphere's 2 pi rho R^3 a. Exact for ellipsoids
/// that are small against the wave.
[[nodiscard]] std::array<RigidDipole, 3>
rigid_dipoles(double mass_kg, const std::array<Vec3, 3>& inertia_kg_m2, double volume_m3);

/// What a listener receives of a body in free air, at all frequencies. From a table with a band
/// (MultipoleTable::Band) the velocities v_l below are interpolated between its frequencies by
/// cubics, their travel time from half the reference radius taken out; constant in their real and
/// proportional to the frequency in their imaginary part below its lowest, constant above.
///
/// From multipoles that are known near each mode's own frequency alone, each degree radiates as
/// from the sphere of the table's reference radius a that moves with the normal velocity which
/// gives the table's pressure at the mode's frequency,
///   p_l = v_l rho j omega E_l,   E_l = -c h_l(k r) / (omega h_l'(k a)),
/// which is causal, falls as a compact source of degree l does towards low frequencies
/// (E_l -> a (a/r)^(l+1)/(l+1)), and is exact at the mode's frequency. The imaginary part of v_l,
/// by which a body differs from a sphere, vanishes towards 0 Hz as j omega tau/(1 + j omega tau).
/// `omega` of each of the table's modes, 1/s; 0: not asked for.
[[nodiscard]] std::unique_ptr<Arrivals>
multipole_arrivals(const ModalTable& table, std::span<const double> omega, const Vec3& listener,
                   const RadiatingSurface::Scene& scene, const std::array<RigidDipole, 3>& rigid,
                   double mass_kg);

} // namespace tactus::modal

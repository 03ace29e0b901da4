#pragma once

#include "core/dsp/complex.hpp"
#include "core/modal/radiation/radiation.hpp"

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace tactus::modal {

/// Spherical Hankel functions of the second kind h_l(x), l = 0 ... max_degree, by upward recursion,
/// which is stable for functions that grow with the degree.
[[nodiscard]] std::vector<Complex> spherical_hankel(std::size_t max_degree, double x);

/// The angular part of a table's multipole series in one direction from the centre.
class MultipoleDirection {
public:
  MultipoleDirection(const ModalTable& table, const Vec3& direction);
  /// The sum over m of c_lm Y_lm(direction) for each degree l of a mode. `ratio`: the present
  /// frequency over the table's; coefficients are interpolated between the table's ratios.
  [[nodiscard]] std::vector<Complex> sums(std::size_t mode, double ratio) const;
  /// The same sums at one of the frequencies of MultipoleTable::Band.
  [[nodiscard]] std::vector<Complex> band_sums(std::size_t mode, std::size_t frequency) const;

private:
  const MultipoleTable* poles_;
  std::vector<Complex> harmonic_; ///< Y_lm at l^2 + l + m
};

/// One translation of a free body as a source of sound: a rigid sphere of the same dipole moment.
struct RigidDipole {
  Vec3 axis{};         ///< principal axis, of length 1
  double radius_m = 0; ///< radius of the equivalent sphere; 0: silent
};
/// The equivalent dipoles of a rigid body along its principal axes.
///
/// The body is replaced by the ellipsoid of its mass and inertia, in incompressible air. Its dipole
/// moment is rho (V + V_e k) a, with V the volume of the body, V_e the volume of the ellipsoid, a
/// the acceleration and k Lamb's inertia coefficients (Lamb 1932, section 114). A sphere of radius
/// R has 2 pi rho R^3 a. Exact for ellipsoids that are small compared with the wavelength.
[[nodiscard]] std::array<RigidDipole, 3>
rigid_dipoles(double mass_kg, const std::array<Vec3, 3>& inertia_kg_m2, double volume_m3);

/// The Arrivals of a body in free air, from the multipoles of its table, at all frequencies.
///
/// Degree l of a mode radiates like a sphere of the table's reference radius a that moves with a
/// normal velocity v_l,
///   p_l = v_l rho j omega E_l,   E_l = -c h_l(k r) / (omega h_l'(k a)).
/// This transfer is causal, and falls towards low frequencies as that of a compact source of degree
/// l, E_l -> a (a/r)^(l+1)/(l+1).
///
/// Tables with multipoles near each mode's own frequency only: v_l gives the table's pressure at
/// that frequency. Its imaginary part, by which a body differs from a sphere, is multiplied by j
/// omega tau/(1 + j omega tau), so that it vanishes at 0 Hz. Tables with a band
/// (MultipoleTable::Band): v_l is interpolated between the band's frequencies by cubics, without
/// the travel time from half the reference radius. Below the lowest frequency its real part is
/// constant and its imaginary part proportional to the frequency; above, it is constant.
///
/// `omega`: angular frequency of each of the table's modes, 1/s; 0: not needed.
[[nodiscard]] std::unique_ptr<Arrivals>
multipole_arrivals(const ModalTable& table, std::span<const double> omega, const Vec3& listener,
                   const RadiatingSurface::Scene& scene, const std::array<RigidDipole, 3>& rigid,
                   double mass_kg);

} // namespace tactus::modal

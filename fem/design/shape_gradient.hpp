#pragma once
#include "fem/design/lattice.hpp"
#include "fem/statics/gradient.hpp"
#include "fem/statics/statics.hpp"

namespace tactus::fem {

/// A derivative by every node's position, [node].
using NodeGradient = std::vector<Vec3>;
[[nodiscard]] std::vector<double> by_parameter(const NodeGradient&,
                                               std::span<const DesignVelocity>);

/// Adds factor * d(v' f_int(u))/dX of the elements' internal forces f_int = integral of B'
/// sigma(u), u and v constant. With H = grad u, G = grad v, S = C sym G and the velocity gradient
/// L:
///   integral of P : L,   P = -(H' S) - (G' sigma) + (sigma : G) I,
/// Eshelby's tensor for u = v. Symmetric in u and v.
void add_internal_force_gradient(const Mesh&, std::span<const ElasticLaw>,
                                 std::span<const double> u, std::span<const double> v,
                                 double factor, NodeGradient& into);

/// Adds factor * d(integral of rho u . v)/dX, the contribution of the mass.
void add_mass_gradient(const Mesh&, std::span<const ElasticLaw>, std::span<const double> u,
                       std::span<const double> v, double factor, NodeGradient& into);

/// Adds factor[e] * dV_e/dX of each element's volume.
void add_volume_gradient(const Mesh&, std::span<const double> factor, NodeGradient& into);

/// Adds factor * d(v' f)/dX of gravity loads' nodal forces.
void add_gravity_gradient(const Mesh&, std::span<const ElasticLaw>, std::span<const Load>,
                          std::span<const double> v, double factor, NodeGradient& into);

/// d/dp, at constant u, of the nodal forces of face loads minus the forces on the springs: f' -
/// K_s' u, by a central difference along the design velocity. along() returns an empty vector if
/// none of these faces moves.
class FaceForceDerivative {
public:
  FaceForceDerivative(const Mesh&, const StaticModel&);
  [[nodiscard]] std::vector<double> along(const DesignVelocity&, std::span<const double> u);

private:
  Mesh mesh_;
  std::span<const Material> materials_;
  std::vector<Load> loads_; ///< loads on faces
  std::span<const SpringPatch> springs_;
  std::vector<std::uint8_t> on_face_; ///< [node]
  double size_;                       ///< mean element size, m
};

} // namespace tactus::fem

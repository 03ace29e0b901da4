#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// The smallest scaled Jacobian at an element's corners and stiffness quadrature points: the
/// determinant over the product of the lengths of its edge vectors there, 1 in a cube and in a
/// regular tetrahedron, 0 where the element is flat, negative where it is inverted (Knupp 2003). At
/// a tetrahedron's or triangle's corners, the corner with the longest edges counts.
[[nodiscard]] double scaled_jacobian(const Mesh&, const Element&);

/// Elements with a smaller scaled Jacobian count as invalid.
inline constexpr double kMinScaledJacobian = 0.05;

/// The admissible part of a step.
struct ValidStep {
  double fraction = 1;        ///< largest fraction at which every element is valid
  std::size_t element = 0;    ///< the element that stops the step, if fraction < 1
  double scaled_jacobian = 1; ///< the smallest among moving elements at that fraction
};

/// The largest fraction, to 1e-3, of the step from the mesh to `target` (node positions, m) after
/// which no element has a scaled Jacobian below `min_quality`, nor less than that share of its
/// volume. The second condition is needed because an element that is flattened evenly keeps its
/// scaled Jacobian. Elements that are below these limits at the start must not get worse.
[[nodiscard]] ValidStep valid_step(const Mesh&, std::span<const Vec3> target,
                                   double min_quality = kMinScaledJacobian);

} // namespace tactus::fem

#pragma once
#include "fem/element/shape.hpp"

#include <span>

namespace tactus::fem {

/// A point of a quadrature rule in the reference element's coordinates, and its weight.
struct QuadraturePoint {
  Vec3 at;
  double weight;
};

/// Points for the stiffness. Exact for straight-sided elements, except for hex20's highest terms: 1
/// point tet4, 4 tet10 (degree 2), 2x2x2 hex8, 3x3x3 hex20, 6x3 wedge15.
[[nodiscard]] std::span<const QuadraturePoint> stiffness_points(Shape);

/// Points for the consistent mass: products of shape functions are integrated exactly on
/// straight-sided elements. tet10: 15 points of degree 5 (Keast 1986).
[[nodiscard]] std::span<const QuadraturePoint> mass_points(Shape);

} // namespace tactus::fem

#pragma once
#include "fem/statics/stress.hpp"

namespace tactus::fem {

/// The stress at nodes, with an estimate of its error.
struct RecoveredStress {
  std::vector<Stress> at_nodes; ///< Pa
  std::vector<double> error;    ///< estimated error of von Mises stress at the nodes, Pa
};

/// Stress extrapolated from an element's best points is linear and misses its curvature, most at
/// the surface. Here each element gets its curvature H from its neighbours, by least squares from
/// G_j - G_e = H (x_j - x_e). G is the gradient of an element's stress at its best points.
/// Extrapolation of x' H x / 2 from these points to a node has a known error, which is removed, so
/// that quadratic stress is exact. The error estimate is the larger of two von Mises values,
/// maximised over the nodes of the surrounding elements: that of this correction, and that of the
/// largest difference between an element and the node's mean. Only elements of the same region are
/// neighbours.
[[nodiscard]] RecoveredStress recovered_stress(const Mesh&, std::span<const Material>,
                                               std::span<const double> displacement);

/// The stress at each element's centre, interpolated from the nodes with the shape functions.
[[nodiscard]] std::vector<Stress> at_middles(const Mesh&, std::span<const Stress> at_nodes);

} // namespace tactus::fem

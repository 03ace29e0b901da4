#pragma once
#include "fem/statics/stress.hpp"

namespace tactus::fem {

/// The stress at nodes, and what it tells of the error.
struct RecoveredStress {
  std::vector<Stress> at_nodes; ///< Pa
  std::vector<double> error;    ///< estimated, of von Mises at the nodes, Pa
};

/// Stress extrapolated from an element's best points is linear and misses its curvature, most at
/// the surface. Here each element takes its curvature from its neighbours: H of G_j - G_e = H (x_j
/// - x_e), G the gradient of an element's stress at its best points, by least squares.
/// Extrapolating x' H x / 2 from these points to a node is wrong by a known amount, which is taken
/// out; quadratic stress is then exact. Estimated is the larger of von Mises of that amount and of
/// the widest difference between an element and the node's mean, over the nodes of the elements
/// around. Neighbours are of the element's own region.
[[nodiscard]] RecoveredStress recovered_stress(const Mesh&, std::span<const Material>,
                                               std::span<const double> displacement);

/// At each element's centre, interpolated from the nodes with the shape functions.
[[nodiscard]] std::vector<Stress> at_middles(const Mesh&, std::span<const Stress> at_nodes);

} // namespace tactus::fem

#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// Weights of control points at every node, fixed when the mesh is embedded: a node moves by sum_c
/// W[node][c] times the displacement of control point c. Compressed by nodes.
struct ControlWeights {
  std::vector<Vec3> control_points; ///< positions before deformation, m
  std::vector<std::size_t> start;   ///< node count + 1
  std::vector<int> control;
  std::vector<double> weight;
};

/// Free-form deformation (Sederberg & Parry 1986): a lattice of control points over a box, with a
/// trivariate tensor product of clamped uniform B-splines (Piegl & Tiller, The NURBS Book, ch. 2).
/// If a direction's degree is one less than its number of points, these are Bernstein polynomials.
struct Lattice {
  Box box;
  std::array<int, 3> points{3, 3, 3}; ///< control points along x, y, z, at least 2
  std::array<int, 3> degree{2, 2, 2}; ///< 1 to points - 1

  /// Number of control point (i, j, k), with i running fastest.
  [[nodiscard]] int control(int i, int j, int k) const noexcept {
    return i + points[0] * (j + points[1] * k);
  }
  [[nodiscard]] int control_count() const noexcept { return points[0] * points[1] * points[2]; }
};

/// Embeds the mesh. Control points lie at the Greville abscissae, so the undeformed lattice
/// reproduces every point of the box. Nodes outside the box do not move; the deformation is
/// continuous across a face of the box if that face's control points are fixed. Refuses impossible
/// lattices and a box without nodes.
[[nodiscard]] ControlWeights embed(const Mesh&, const Lattice&);

/// Imports weights made elsewhere (a Catmull-Clark volume, a hexahedral cage subdivided once):
/// dense, row by row, [node][control]. Refuses a wrong size, values that are not numbers, and rows
/// whose sum is neither 1 (the node moves with the cage) nor 0 (it does not move).
[[nodiscard]] ControlWeights import_weights(const Mesh&, std::vector<Vec3> control_points,
                                            std::span<const double> weights);

/// dX/dp of one shape parameter, the design velocity (Choi & Kim, Structural Sensitivity Analysis
/// and Optimization 1, ch. 6): the nodes that move, and their displacement per unit of the
/// parameter.
struct DesignVelocity {
  std::string name;
  std::vector<int> node;
  std::vector<Vec3> velocity;
};

/// One direction of a control point, or of several points that move together: parameter p moves
/// control point c by p * direction.
struct ShapeParameter {
  std::string name;
  std::vector<int> controls;
  Vec3 direction;
};

/// One row of `parameters`: a coordinate of a control point and the bounds of its displacement.
struct ParameterRange {
  int control = 0, axis = 0;
  double low = 0, high = 0; ///< m
};

/// The parameters x, y and z of each given control point, in that order, named "cp 5 x" etc.
[[nodiscard]] std::vector<ShapeParameter> free_parameters(std::span<const int> controls);

/// Refuses control points that do not exist and parameters that move no node.
[[nodiscard]] std::vector<DesignVelocity> design_velocities(const ControlWeights&,
                                                            std::span<const ShapeParameter>);

/// Returns X0 + sum_k p_k dX/dp_k for all nodes.
[[nodiscard]] std::vector<Vec3> moved_nodes(std::span<const Vec3> nodes,
                                            std::span<const DesignVelocity>,
                                            std::span<const double> parameters);

} // namespace tactus::fem

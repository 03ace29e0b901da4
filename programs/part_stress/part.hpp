#pragma once
#include "fem/design/reanalysis.hpp"
#include "fem/io/stress_table.hpp"
#include "programs/body/budget.hpp"
#include "programs/part_stress/order.hpp"

namespace tactus::fem {

/// The mesh that is ordered, checked. Refuses what is beyond the memory, separate parts and bad
/// elements.
[[nodiscard]] Mesh mesh_of(const PartOrder&, ProgressLine&);

/// Supports and loads on the mesh. Refuses a place that meets nothing, naming the option.
[[nodiscard]] StaticModel model_of(const PartOrder&, const Mesh&);

/// How the part may change its shape.
struct DesignSpace {
  Lattice lattice;
  ControlWeights weights;
  std::vector<int> controls; ///< that may move
  std::vector<ParameterRange> parameters;
  std::vector<DesignVelocity> velocities; ///< of the parameters
  double trust = 0;                       ///< m
};

/// The control lattice around the part or in its box. Control points of a face of the box that the
/// body passes through stay, so that the body stays in one piece; so do those that move no node.
/// Bounds are cut where a coordinate alone would turn an element inside out.
[[nodiscard]] DesignSpace design_space_of(const PartOrder&, const Mesh&);

/// The parameters of the ordered moves. Refuses a control point that may not move.
[[nodiscard]] std::vector<double> parameters_of(std::span<const Move>, const DesignSpace&);

} // namespace tactus::fem

#pragma once
#include "fem/io/load.hpp"
#include "fem/mesh/prism.hpp"

namespace tactus::fem {

/// Settings for meshing and sweeping the base of a prism.
struct SweepChoice {
  bool quadrilaterals = true; ///< pairs triangles to quadrilaterals where possible
  bool curved = true;         ///< edges follow the base's curves
  double unit = 1;            ///< metres per unit of the model
};

/// Meshes the base of a prism with gmsh (second order) and sweeps it through `levels` (fractions of
/// the height, 0 to 1): hex20 and wedge15, m. An element's three intervals are the number of its
/// base cell, twice, and the number of its layer, which continues the numbering. gmsh's model keeps
/// only the base. Cells that their curved edges would invert get straight edges.
[[nodiscard]] Mesh sweep(const Prism&, std::span<const double> levels, const SweepChoice&);

/// Meshes gmsh's model as a swept mesh if it is a prism, with the sizes of `size_for` or of a
/// refinement, which must have levels. Predicts the mesh's size first. Refuses a mesh whose volume
/// differs from the solid's.
[[nodiscard]] std::optional<Mesh> swept_mesh(const LoadChoice&, double unit, bool quadrilaterals);

} // namespace tactus::fem

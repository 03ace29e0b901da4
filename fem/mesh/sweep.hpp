#pragma once
#include "fem/io/load.hpp"
#include "fem/mesh/prism.hpp"

namespace tactus::fem {

/// How the base of a prism is meshed and swept.
struct SweepChoice {
  bool quadrilaterals = true; ///< pairs triangles to quadrilaterals where possible
  bool curved = true;         ///< edges follow the base's curves
  double unit = 1;            ///< metres a unit of the model
};

/// Meshes the base of a prism with gmsh (second order) and sweeps it through `levels` (fractions of
/// the height, 0 to 1): hex20 and wedge15, m. An element's three intervals are the number of its
/// base cell (twice) and, continuing the numbering, of its layer. gmsh's model keeps only the base.
/// Cells whose curved edges would invert them get straight ones.
[[nodiscard]] Mesh sweep(const Prism&, std::span<const double> levels, const SweepChoice&);

/// gmsh's model as a swept mesh, if it is a prism: with the sizes of `size_for` or those of a
/// refinement, which must have levels. Predicts its size first. Refuses a mesh whose volume differs
/// from the solid's.
[[nodiscard]] std::optional<Mesh> swept_mesh(const LoadChoice&, double unit, bool quadrilaterals);

} // namespace tactus::fem

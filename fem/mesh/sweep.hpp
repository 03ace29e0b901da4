#pragma once
#include "fem/io/load.hpp"
#include "fem/mesh/prism.hpp"

namespace tactus::fem {

/// How the base of a prism is meshed and swept.
struct SweepChoice {
  bool quadrilaterals = true; ///< of pairs of triangles, where that is possible
  bool curved = true;         ///< sides follow the base's curved edges
  double unit = 1;            ///< metres a unit of the model
};

/// Meshes the base of a prism by gmsh (second order) and sweeps it through `levels` (shares of the
/// height, 0 to 1): hex20 and wedge15, m. An element's three intervals are the number of its cell
/// of the base (twice) and of its layer, numbered on. gmsh's model keeps the base alone. Cells
/// whose curved sides turn them inside out get straight ones.
[[nodiscard]] Mesh sweep(const Prism&, std::span<const double> levels, const SweepChoice&);

/// gmsh's model as a swept mesh, if it is a prism: with the sizes of `size_for` or those of a
/// refinement, which must have levels. Predicts its size first. Refuses what has another volume.
[[nodiscard]] std::optional<Mesh> swept_mesh(const LoadChoice&, double unit, bool quadrilaterals);

} // namespace tactus::fem

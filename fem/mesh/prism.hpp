#pragma once
#include "fem/mesh/mesh.hpp"

#include <optional>

namespace tactus::fem {

/// A CAD solid that is a flat outline moved along its normal: sheets and plates with holes, bars,
/// cylinders, profiles. Lengths are the model's.
struct Prism {
  int volume = 0;
  std::vector<int> base; ///< gmsh's tags of the faces at its lower end
  Vector3 direction;     ///< from the base to the other end, of unit length
  double height = 0;
};

/// gmsh's only volume as a prism, if it is one: all its faces are planes across one direction, at
/// two levels, or run along it, and its volume is the base times the height. A block is one in
/// three directions; the lowest height is taken.
[[nodiscard]] std::optional<Prism> find_prism();

struct SweepChoice {
  bool quadrilaterals = true; ///< of pairs of triangles, where that is possible
  bool curved = true;
  double unit = 1; ///< metres a unit of the model
};

/// gmsh's quadratic mesh of the base moved through `levels` (shares of the height, 0 to 1): hex20
/// and wedge15, whose intervals are the number of their cell of the base (twice) and, numbered on,
/// of their layer. Metres. gmsh's model keeps the base alone. Cells whose curved sides turn them
/// inside out get straight ones.
[[nodiscard]] Mesh sweep(const Prism&, std::span<const double> levels, const SweepChoice&);

/// The shares of the height between equal layers.
[[nodiscard]] std::vector<double> even_levels(double height, double h);

} // namespace tactus::fem

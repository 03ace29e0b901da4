#pragma once
#include "fem/mesh/mesh.hpp"

#include <optional>

namespace tactus::fem {

/// A CAD solid that is a flat outline moved along its normal: sheets and plates with holes, bars,
/// cylinders, profiles. Lengths are the model's.
struct Prism {
  int volume = 0;
  std::vector<int> base;                  ///< gmsh's tags of the faces at its lower end
  Vec3 direction;                         ///< from the base to the other end, of unit length
  double height = 0, solid = 0, skin = 0; ///< its length, volume and area
  Vec3 box;                               ///< sides of the bounding box
};

/// gmsh's only volume as a prism, if it is one: all its faces are planes across one direction, at
/// two levels, or run along it, and its volume is the base times the height. A block is one in
/// three directions; the lowest height is taken.
[[nodiscard]] std::optional<Prism> find_prism();

} // namespace tactus::fem

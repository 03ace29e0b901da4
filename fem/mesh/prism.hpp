#pragma once
#include "fem/mesh/mesh.hpp"

#include <optional>

namespace tactus::fem {

/// A CAD solid that is a flat outline moved along its normal: sheets and plates with holes, bars,
/// cylinders, profiles. Lengths are the model's.
struct Prism {
  int volume = 0;
  std::vector<int> base;                  ///< gmsh's tags of the faces at its lower end
  Vec3 direction;                         ///< unit vector from the base to the other end
  double height = 0, solid = 0, skin = 0; ///< the prism's length, volume and skin area
  Vec3 box;                               ///< sides of the bounding box
};

/// gmsh's only volume as a prism, if it is one. All faces of a prism are either planes across one
/// direction, at two levels, or parallel to that direction, and its volume is base times height. A
/// block is a prism in three directions; the one with the smallest height is used.
[[nodiscard]] std::optional<Prism> find_prism();

} // namespace tactus::fem

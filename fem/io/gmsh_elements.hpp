#pragma once
#include "fem/element/shape.hpp"

#include <array>
#include <optional>

namespace tactus::fem {

/// One of gmsh's element types (gmsh reference manual, "MSH file format", elm-type).
struct GmshElement {
  int type;
  const char* name; ///< "10-node tetrahedron"
  int dimension;    ///< 0 to 3
  int nodes;
  std::optional<Shape> shape{};  ///< ours, for the volume elements that are solved
  std::array<int, 20> from = {}; ///< our node i is gmsh's node from[i]
};

/// The type of that number, or null when there is none.
[[nodiscard]] const GmshElement* gmsh_element(int type) noexcept;

} // namespace tactus::fem

#pragma once
#include "fem/element/shape.hpp"

#include <array>
#include <optional>

namespace tactus::fem {

/// One of gmsh's element types (gmsh reference manual, "MSH file format", elm-type).
struct GmshElement {
  int type;
  const char* name; ///< such as "10-node tetrahedron"
  int dimension;    ///< 0 to 3
  int nodes;
  std::optional<Shape> shape{};  ///< our shape, for volume elements that can be solved
  std::array<int, 20> from = {}; ///< our node i is gmsh's node from[i]
};

/// The type of that number, or null if there is none.
[[nodiscard]] const GmshElement* gmsh_element(int type) noexcept;

} // namespace tactus::fem

#pragma once
#include "fem/mesh/mesh.hpp"

#include <array>

namespace tactus::fem {

/// The body's skin as flat triangles, outward. Every node of the skin is a vertex, the middle nodes
/// of quadratic faces too: six nodes give four triangles, eight give six.
struct Surface {
  std::vector<int> node; ///< mesh node of each vertex, ascending
  std::vector<std::array<int, 3>> triangles;
};
[[nodiscard]] Surface surface_of(const Mesh&);

} // namespace tactus::fem

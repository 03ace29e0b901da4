#pragma once
#include "fem/mesh/mesh.hpp"

#include <array>

namespace tactus::fem {

/// A face of an element: its index in faces(shape).
struct MeshFace {
  int element = 0, face = 0;
  friend bool operator==(const MeshFace&, const MeshFace&) = default;
};

/// The faces that belong to only one element, ascending by element and face. Refuses a face that
/// three elements share.
[[nodiscard]] std::vector<MeshFace> outer_faces(const Mesh&);

/// The body's skin as flat triangles, oriented outward. Every node of the skin is a vertex,
/// including mid-edge nodes: a face with six nodes gives four triangles, one with eight gives six.
struct Surface {
  std::vector<int> node; ///< mesh node of each vertex, ascending
  std::vector<std::array<int, 3>> triangles;
};
[[nodiscard]] Surface surface_of(const Mesh&);

} // namespace tactus::fem

#pragma once
#include "fem/mesh/surface.hpp"

namespace tactus::fem {

/// One quadrature point of a face.
struct FacePoint {
  std::array<double, 8> value{}; ///< N of the face's nodes, in the order of Face::node
  Vec3 area;                     ///< outward normal times weight times dA, m^2
};

/// The quadrature points of a face (tri3, tri6, quad4, quad8), outward. 4x4 conical Gauss points on
/// triangles (exact to degree 6: springs on curved tri6), 3x3 Gauss points on quadrilaterals. The
/// span is valid until the next call in the same thread.
[[nodiscard]] std::span<const FacePoint> face_points(const Mesh&, const MeshFace&);

/// Mesh nodes of a face: corners, then edge nodes.
struct FaceNodes {
  std::array<std::size_t, 8> node{};
  std::size_t count = 0;
};
[[nodiscard]] FaceNodes face_nodes(const Mesh&, const MeshFace&);

/// Refuses faces that the mesh does not have; `label` names their owner.
void check_faces(const Mesh&, std::span<const MeshFace>, const std::string& label);

} // namespace tactus::fem

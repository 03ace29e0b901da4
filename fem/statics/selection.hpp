#pragma once
#include "fem/mesh/surface.hpp"

#include <string>
#include <variant>

namespace tactus::fem {

/// Points inside an axis-parallel box, m.
struct InBox {
  Box box;
};
/// Points within `tolerance_m` of the plane through `point` with the normal `normal` (any length).
struct OnPlane {
  Vec3 point, normal;
};
/// Points within `tolerance_m` of the sphere's surface; inside it if `solid`.
struct OnSphere {
  Vec3 centre;
  double radius = 0;
  bool solid = false;
};
/// Points within `tolerance_m` of the lateral surface of the cylinder from `start` to `end`; inside
/// it if `solid`.
struct OnCylinder {
  Vec3 start, end;
  double radius = 0;
  bool solid = false;
};
/// Nodes of one of the mesh's named sets (physical surfaces of an .msh file, *NSET of an .inp).
struct InNodeSet {
  std::string name;
};

/// A part of the body, chosen by geometry. `tolerance_m` also widens boxes; 0 stands for 1e-6 of
/// the mesh's largest extent.
struct Selection {
  std::variant<InBox, OnPlane, OnSphere, OnCylinder, InNodeSet> region;
  double tolerance_m = 0;
};

/// Nodes in the region, ascending, including interior nodes. Refuses impossible regions (a radius
/// or normal of zero, a box with low above high), unknown names, and a region without nodes.
[[nodiscard]] std::vector<int> select_nodes(const Mesh&, const Selection&);

/// Faces of the skin all of whose nodes lie in the region. Refuses the same regions as
/// select_nodes(), and a region without faces.
[[nodiscard]] std::vector<MeshFace> select_faces(const Mesh&, const Selection&);

/// The nodes of faces, ascending.
[[nodiscard]] std::vector<int> nodes_of_faces(const Mesh&, std::span<const MeshFace>);

} // namespace tactus::fem

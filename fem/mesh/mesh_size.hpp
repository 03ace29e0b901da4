#pragma once
#include "core/geometry/vec3.hpp"

#include <array>

namespace tactus::fem {

struct Mesh;

/// The predicted size of a mesh. Counts are doubles, so that no element size, however absurd,
/// causes an overflow.
struct MeshSize {
  double elements = 0, nodes = 0;
  double node_pairs = 0;     ///< pairs of the node graph's lower triangle, with the diagonal
  double skin_triangles = 0; ///< triangles of the surface; it has half as many vertices
  /// Elements along the body's three directions, as if it were a block of hex20. The fill of its
  /// factor depends on them. A plate is {many, many, few}, a bar {many, few, few}.
  std::array<double, 3> cells{};
  double nodes_made = 0;      ///< nodes in memory before they are merged
  double nodes_on_planes = 1; ///< nodes on a plane across `cells`, relative to hex20
  double volume = 0;          ///< m^3
  double skin_area = 0;       ///< m^2, for gmsh's meshes
  double h = 0;               ///< m, element size requested from gmsh; 0 if unknown
  double height = 0;          ///< m, height of a swept body; 0 if not swept
  Vec3 box{};                 ///< m, the bounding box's sides
  [[nodiscard]] double dofs() const noexcept { return 3 * nodes; }
};

/// The size of a mesh that has been made. `cells` follow from the number of elements and the body's
/// wall thickness, twice its volume over its skin area.
[[nodiscard]] MeshSize size_of(const Mesh&);

/// Predicts the size of gmsh's tet10 mesh from a body's volume, skin area and box and an element
/// size h, all in metres. `faces` is the number of the surface's triangles if it is already meshed.
/// The number of elements is right within a fifth for ungraded meshes; graded meshes with their
/// `faces` have up to twice as many.
[[nodiscard]] MeshSize predict_tetrahedra(double volume, double skin_area, const Vec3& box,
                                          double h, double faces = 0);

/// Predicts the size of a swept mesh (sweep.hpp) of wedge15, from triangles of edge h in the base
/// and the number of layers.
[[nodiscard]] MeshSize predict_swept_size(double volume, double skin_area, const Vec3& box,
                                          double height, double h, double layers);

/// The size of a mesh of the same body and kind with another number of elements.
[[nodiscard]] MeshSize scaled(const MeshSize&, double elements);

/// The size that a gmsh mesh would have with another element size and the same grading.
[[nodiscard]] MeshSize resized_tetrahedra(const MeshSize&, double h);

} // namespace tactus::fem

#pragma once
#include "core/geometry/vec3.hpp"

#include <array>

namespace tactus::fem {

struct Mesh;

/// The predicted size of a mesh. Counts are doubles, so that an absurd element size overflows
/// nothing.
struct MeshSize {
  double elements = 0, nodes = 0;
  double node_pairs = 0;     ///< of the node graph's lower triangle, the diagonal included
  double skin_triangles = 0; ///< of the surface's mesh, vertices half as many
  /// Elements along the body's three directions, as if it were a block of hex20: what the fill of
  /// its factor depends on. A plate is {many, many, few}, a bar {many, few, few}.
  std::array<double, 3> cells{};
  double nodes_made = 0;      ///< nodes in memory before they are merged
  double nodes_on_planes = 1; ///< on a plane across `cells`, relative to hex20
  double volume = 0;          ///< m^3
  double skin_area = 0;       ///< m^2, of gmsh's meshes
  double h = 0;               ///< m, the element size requested of gmsh; 0: unknown
  double height = 0;          ///< m, height of a swept body; 0: not swept
  Vec3 box{};                 ///< m, the bounding box's sides
  [[nodiscard]] double dofs() const noexcept { return 3 * nodes; }
};

/// The size of a mesh that has been made. `cells` from its elements' number and the body's wall,
/// twice its volume over its skin.
[[nodiscard]] MeshSize size_of(const Mesh&);

/// The size of gmsh's tet10 mesh of a body of a volume, skin area and box for an element size h,
/// all in metres; `faces`, when the surface is meshed already, is the number of its triangles.
/// Ungraded meshes have within a fifth of the elements predicted, graded ones with their `faces` up
/// to twice as many.
[[nodiscard]] MeshSize predict_tetrahedra(double volume, double skin_area, const Vec3& box,
                                          double h, double faces = 0);

/// The size of a swept mesh (sweep.hpp) of wedge15: triangles of edge h in the base's area, layers.
[[nodiscard]] MeshSize predict_swept_size(double volume, double skin_area, const Vec3& box,
                                          double height, double h, double layers);

/// The size of a mesh of the same body and kind with another number of elements.
[[nodiscard]] MeshSize scaled(const MeshSize&, double elements);

/// The size that a gmsh mesh would have with another element size, its grading kept.
[[nodiscard]] MeshSize resized_tetrahedra(const MeshSize&, double h);

} // namespace tactus::fem

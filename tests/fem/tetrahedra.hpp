#pragma once
#include "fem/mesh/surface.hpp"

namespace tactus::fem {

/// A box of cells, each of six straight tetrahedra that share the cell's long diagonal.
inline Mesh tetrahedral_box(const std::array<int, 3>& cells, const Vec3& size, bool quadratic) {
  static constexpr std::array<std::array<int, 4>, 6> kCells{
      {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
  static constexpr std::array<std::array<std::size_t, 2>, 6> kEdges{
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  Mesh mesh;
  for (int k = 0; k < cells[2]; ++k)
    for (int j = 0; j < cells[1]; ++j)
      for (int i = 0; i < cells[0]; ++i)
        for (const auto& cell : kCells) {
          std::vector<Vec3> corners;
          for (const int c : cell)
            corners.push_back({size.x / cells[0] * (i + c % 2), size.y / cells[1] * (j + c / 2 % 2),
                               size.z / cells[2] * (k + c / 4)});
          if (quadratic)
            for (const auto& [a, b] : kEdges)
              corners.push_back(.5 * (corners[a] + corners[b]));
          std::vector<int> nodes;
          for (const Vec3& p : corners) {
            nodes.push_back(static_cast<int>(mesh.nodes.size()));
            mesh.nodes.push_back(p);
          }
          mesh.add(quadratic ? Shape::tet10 : Shape::tet4, nodes);
        }
  merge_nodes(mesh, 1e-9);
  return mesh;
}

/// The unit cube in n^3 cells.
inline Mesh tetrahedral_block(int n, bool quadratic) {
  return tetrahedral_box({n, n, n}, {1, 1, 1}, quadratic);
}

inline std::vector<int> outer_nodes(const Mesh& mesh) { return surface_of(mesh).node; }

} // namespace tactus::fem

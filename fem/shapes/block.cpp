#include "fem/shapes/block.hpp"

namespace tactus::fem {

Mesh block(std::span<const double> xs, std::span<const double> ys, std::span<const double> zs) {
  // Uses a lattice twice as fine; hex20 has no node where two or three indices are odd.
  const std::size_t nx = 2 * xs.size() - 1, ny = 2 * ys.size() - 1, nz = 2 * zs.size() - 1;
  const auto coordinate = [](std::span<const double> at, std::size_t i) {
    return i % 2 == 0 ? at[i / 2] : .5 * (at[i / 2] + at[i / 2 + 1]);
  };
  Mesh mesh;
  std::vector<int> number(nx * ny * nz, -1);
  for (std::size_t k = 0; k < nz; ++k)
    for (std::size_t j = 0; j < ny; ++j)
      for (std::size_t i = 0; i < nx; ++i)
        if (i % 2 + j % 2 + k % 2 <= 1) {
          number[(k * ny + j) * nx + i] = static_cast<int>(mesh.nodes.size());
          mesh.nodes.push_back({coordinate(xs, i), coordinate(ys, j), coordinate(zs, k)});
        }
  const auto reference = reference_nodes(Shape::hex20);
  for (std::size_t k = 0; k + 1 < zs.size(); ++k)
    for (std::size_t j = 0; j + 1 < ys.size(); ++j)
      for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
        std::array<int, 20> nodes;
        for (std::size_t a = 0; a < 20; ++a) {
          const Vec3& p = reference[a];
          const auto x = 2 * i + static_cast<std::size_t>(p.x + 1);
          const auto y = 2 * j + static_cast<std::size_t>(p.y + 1);
          const auto z = 2 * k + static_cast<std::size_t>(p.z + 1);
          nodes[a] = number[(z * ny + y) * nx + x];
        }
        mesh.add(Shape::hex20, nodes);
        const std::size_t first_y = xs.size() - 1, first_z = first_y + ys.size() - 1;
        mesh.elements.back().interval = {static_cast<int>(i), static_cast<int>(first_y + j),
                                         static_cast<int>(first_z + k)};
      }
  return mesh;
}

} // namespace tactus::fem

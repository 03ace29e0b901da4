#include "fem/error/singular.hpp"

#include "fem/mesh/surface.hpp"

#include <algorithm>
#include <array>

namespace tactus::fem {

std::vector<std::uint8_t> singular_elements(const Mesh& mesh, std::span<const std::uint8_t> held) {
  std::vector<std::uint8_t> singular_node(mesh.nodes.size(), 0);
  const Surface skin = surface_of(mesh);
  const auto node = [&](int v) {
    return static_cast<std::size_t>(skin.node[static_cast<std::size_t>(v)]);
  };
  struct Side {
    std::array<std::size_t, 2> edge;
    std::size_t triangle;
  };
  std::vector<Side> sides;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const auto& corners = skin.triangles[t];
    std::size_t fixed = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t a = node(corners[k]), b = node(corners[(k + 1) % 3]);
      sides.push_back({{std::min(a, b), std::max(a, b)}, t});
      fixed += held[3 * a] || held[3 * a + 1] || held[3 * a + 2];
    }
    if (fixed == 1 || fixed == 2)
      for (std::size_t k = 0; k < 3; ++k)
        if (const std::size_t n = node(corners[k]);
            held[3 * n] || held[3 * n + 1] || held[3 * n + 2])
          singular_node[n] = 1;
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.edge, a.triangle) < std::tie(b.edge, b.triangle);
  });
  const double limit = std::sin(20 * 3.14159265358979 / 180);
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    if (sides[i].edge != sides[i + 1].edge)
      continue;
    const auto& [a, b] = sides[i].edge;
    const auto& f = skin.triangles[sides[i].triangle];
    const auto& g = skin.triangles[sides[i + 1].triangle];
    const auto at = [&](int v) { return mesh.nodes[node(v)]; };
    const Vector3 normal = cross(at(f[1]) - at(f[0]), at(f[2]) - at(f[0]));
    Vector3 away;
    for (const int v : g)
      if (node(v) != a && node(v) != b)
        away = at(v) - .5 * (mesh.nodes[a] + mesh.nodes[b]);
    // The far corner of one triangle rises above the outward plane of the other.
    if (dot(normal, away) > limit * length(normal) * length(away))
      singular_node[a] = singular_node[b] = 1;
  }
  std::vector<std::uint8_t> singular;
  for (const Element& e : mesh.elements) {
    const auto nodes = mesh.nodes_of(e);
    singular.push_back(std::any_of(nodes.begin(), nodes.end(), [&](int n) {
      return singular_node[static_cast<std::size_t>(n)] != 0;
    }));
  }
  return singular;
}

} // namespace tactus::fem

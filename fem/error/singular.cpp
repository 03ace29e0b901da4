#include "fem/error/singular.hpp"

#include "fem/mesh/surface.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace tactus::fem {

std::vector<std::uint8_t> singular_nodes(const Mesh& mesh,
                                         std::span<const std::uint8_t> constrained, double turn) {
  std::vector<std::uint8_t> singular_node(mesh.nodes.size(), 0);
  const Surface skin = surface_of(mesh);
  const auto node = [&](int v) {
    return static_cast<std::size_t>(skin.node[static_cast<std::size_t>(v)]);
  };
  const auto at = [&](int v) { return mesh.nodes[node(v)]; };
  const auto normal = [&](const std::array<int, 3>& t) {
    return cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
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
      fixed += constrained[3 * a] || constrained[3 * a + 1] || constrained[3 * a + 2];
    }
    if (fixed == 1 || fixed == 2) {
      const Vec3 across = normal(corners);
      for (const int corner : corners)
        for (int i = 0; i < 3; ++i)
          if (constrained[3 * node(corner) + static_cast<std::size_t>(i)] &&
              std::abs(across[i]) > .3 * length(across))
            singular_node[node(corner)] = 1;
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.edge, a.triangle) < std::tie(b.edge, b.triangle);
  });
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    if (sides[i].edge != sides[i + 1].edge)
      continue;
    const auto& [a, b] = sides[i].edge;
    const auto& f = skin.triangles[sides[i].triangle];
    const Vec3 n = normal(f), m = normal(skin.triangles[sides[i + 1].triangle]);
    // The angle from one normal to the next about the edge, in the direction of the first triangle;
    // positive where the body is convex. The far corners would not give its sign: on thin facets at
    // a round edge, the roundness moves them more than the facet does.
    Vec3 along = mesh.nodes[b] - mesh.nodes[a];
    for (std::size_t k = 0; k < 3; ++k)
      if (node(f[k]) == b && node(f[(k + 1) % 3]) == a)
        along = -1 * along;
    if (std::atan2(dot(cross(n, m), along) / length(along), dot(n, m)) < -turn)
      singular_node[a] = singular_node[b] = 1;
  }
  return singular_node;
}

std::vector<std::uint8_t> singular_elements(const Mesh& mesh,
                                            std::span<const std::uint8_t> constrained) {
  const std::vector<std::uint8_t> singular_node = singular_nodes(mesh, constrained, kSharpTurn);
  std::vector<std::uint8_t> singular;
  for (const Element& e : mesh.elements) {
    const auto nodes = mesh.nodes_of(e);
    singular.push_back(std::any_of(nodes.begin(), nodes.end(), [&](int n) {
      return singular_node[static_cast<std::size_t>(n)] != 0;
    }));
  }
  return singular;
}

std::vector<std::array<std::uint8_t, 3>> singular_axes(const Mesh& mesh,
                                                       std::span<const std::uint8_t> constrained) {
  const std::vector<std::uint8_t> singular_node = singular_nodes(mesh, constrained, kSharpTurn);
  std::vector<std::array<std::uint8_t, 3>> axes;
  for (const Element& e : mesh.elements) {
    const auto nodes = mesh.nodes_of(e);
    const auto corners = static_cast<std::size_t>(corner_count(e.shape));
    const auto on_line = [&](std::size_t c) {
      return singular_node[static_cast<std::size_t>(nodes[c])] != 0;
    };
    bool any = false;
    for (std::size_t c = 0; c < corners; ++c)
      any = any || on_line(c);
    auto& of = axes.emplace_back(std::array<std::uint8_t, 3>{any, any, any});
    if (!any)
      continue;
    // The line runs along an axis if it meets the corners at both ends of that axis or neither.
    const auto reference = reference_nodes(e.shape);
    for (std::size_t axis = e.shape == Shape::wedge15 ? 2 : 0;
         axis < (e.shape == Shape::wedge15 || e.shape == Shape::hex20 ? 3U : 0U); ++axis) {
      bool along = true;
      for (std::size_t a = 0; a < corners; ++a)
        for (std::size_t b = 0; b < a; ++b) {
          Vec3 separation = reference[a] - reference[b];
          separation[static_cast<int>(axis)] = 0;
          if (dot(separation, separation) < 1e-9)
            along = along && on_line(a) == on_line(b);
        }
      of[axis] = !along;
    }
  }
  return axes;
}

} // namespace tactus::fem

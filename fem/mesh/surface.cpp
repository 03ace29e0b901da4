#include "fem/mesh/surface.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace tactus::fem {

std::vector<MeshFace> outer_faces(const Mesh& mesh) {
  struct Use {
    std::size_t element, face;
    int count;
  };
  std::map<std::array<int, 4>, Use> uses;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const auto nodes = mesh.nodes_of(mesh.elements[e]);
    const auto all = faces(mesh.elements[e].shape);
    for (std::size_t f = 0; f < all.size(); ++f) {
      std::array<int, 4> key{-1, -1, -1, -1};
      for (int c = 0; c < all[f].corners; ++c)
        key[static_cast<std::size_t>(c)] =
            nodes[static_cast<std::size_t>(all[f].node[static_cast<std::size_t>(c)])];
      std::sort(key.begin(), key.end());
      const auto [at, added] = uses.try_emplace(key, Use{e, f, 0});
      if (++at->second.count > 2)
        throw InputError("element " + std::to_string(e + 1) +
                         " shares a face with two others, expected at most one");
    }
  }
  std::vector<MeshFace> outer;
  for (const auto& [key, use] : uses)
    if (use.count == 1)
      outer.push_back({static_cast<int>(use.element), static_cast<int>(use.face)});
  std::sort(outer.begin(), outer.end(), [](const MeshFace& a, const MeshFace& b) {
    return std::tie(a.element, a.face) < std::tie(b.element, b.face);
  });
  return outer;
}

Surface surface_of(const Mesh& mesh) {
  Surface surface;
  using Pattern = std::vector<std::array<int, 3>>;
  static const Pattern tri3{{0, 1, 2}}, tri6{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};
  static const Pattern quad4{{0, 1, 2}, {0, 2, 3}};
  static const Pattern quad8{{0, 4, 7}, {1, 5, 4}, {2, 6, 5}, {3, 7, 6}, {4, 5, 6}, {4, 6, 7}};
  static const Pattern crosswise{{0, 4, 7}, {1, 5, 4}, {2, 6, 5}, {3, 7, 6}, {4, 5, 7}, {5, 6, 7}};
  for (const auto& [e, f] : outer_faces(mesh)) {
    const Element& element = mesh.elements[static_cast<std::size_t>(e)];
    const auto nodes = mesh.nodes_of(element);
    const Face& face = faces(element.shape)[static_cast<std::size_t>(f)];
    const bool linear = is_linear(element.shape);
    const auto across = [&](std::size_t i, std::size_t j) {
      const auto at = [&](std::size_t k) {
        return mesh.nodes[static_cast<std::size_t>(nodes[static_cast<std::size_t>(face.node[k])])];
      };
      return length(at(i) - at(j));
    };
    // Takes the shorter diagonal through the middle: along the longer one, a low face on a curved
    // wall would tilt by more than its height.
    const bool cross = face.corners == 4 && !linear && across(5, 7) < (1 - 1e-6) * across(4, 6);
    const Pattern& pattern = face.corners == 3 ? (linear ? tri3 : tri6)
                             : linear          ? quad4
                             : cross           ? crosswise
                                               : quad8;
    for (const auto& t : pattern) {
      std::array<int, 3> triangle;
      for (std::size_t k = 0; k < 3; ++k)
        triangle[k] = nodes[static_cast<std::size_t>(face.node[static_cast<std::size_t>(t[k])])];
      surface.triangles.push_back(triangle);
    }
  }
  for (const auto& t : surface.triangles)
    surface.node.insert(surface.node.end(), t.begin(), t.end());
  std::sort(surface.node.begin(), surface.node.end());
  surface.node.erase(std::unique(surface.node.begin(), surface.node.end()), surface.node.end());
  for (auto& t : surface.triangles)
    for (int& n : t)
      n = static_cast<int>(std::lower_bound(surface.node.begin(), surface.node.end(), n) -
                           surface.node.begin());
  return surface;
}

} // namespace tactus::fem

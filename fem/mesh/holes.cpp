#include "fem/mesh/holes.hpp"

#include "fem/io/obj.hpp"
#include "fem/mesh/edge_uses.hpp"

#include <map>

namespace tactus::fem {

std::vector<Hole> close_holes(Triangles& t, double area_share, double extent_share) {
  std::map<int, std::pair<int, std::size_t>> next; // along a ring, against its triangles
  double skin = 0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    skin += .5 * length(t.normal(i));
  const auto uses = edge_uses(t);
  each_edge(uses, [&](auto first, auto last) {
    if (last - first == 1)
      next[first->forward ? first->b : first->a] = {first->forward ? first->a : first->b,
                                                    first->triangle};
  });
  const double size = bounding_box(t.points).largest();
  std::vector<Hole> holes;
  while (!next.empty()) {
    const int start = next.begin()->first;
    const std::size_t beside = next.begin()->second.second;
    std::vector<int> ring;
    std::vector<Vector3> corners;
    for (auto step = next.find(start); step != next.end(); step = next.find(ring.back())) {
      if (ring.empty())
        ring.push_back(start);
      const int to = step->second.first;
      next.erase(step);
      if (to == start)
        break;
      ring.push_back(to);
    }
    Hole hole;
    for (const int v : ring) {
      corners.push_back(t.points[static_cast<std::size_t>(v)]);
      hole.centre += (1. / static_cast<double>(ring.size())) * corners.back();
    }
    hole.edges = ring.size();
    hole.extent = bounding_box(corners).largest();
    const bool small = hole.extent <= extent_share * size && ring.size() <= 4096;
    const auto patch = small ? cut_ears(corners) : std::vector<std::array<int, 3>>{};
    const auto at = [&](int i) { return corners[static_cast<std::size_t>(i)]; };
    for (const auto& [a, b, c] : patch)
      hole.area += .5 * length(cross(at(b) - at(a), at(c) - at(a)));
    hole.closed = small && ring.size() > 2 && hole.area <= area_share * skin;
    if (hole.closed)
      for (const auto& ear : patch) {
        std::array<int, 3> triangle{};
        for (std::size_t k = 0; k < 3; ++k)
          triangle[k] = ring[static_cast<std::size_t>(ear[k])];
        t.triangles.push_back(triangle);
        if (!t.group.empty())
          t.group.push_back(t.group[beside]);
      }
    holes.push_back(hole);
  }
  std::stable_sort(holes.begin(), holes.end(),
                   [](const Hole& a, const Hole& b) { return a.extent > b.extent; });
  return holes;
}

} // namespace tactus::fem

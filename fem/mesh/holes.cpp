#include "fem/mesh/holes.hpp"

#include "fem/mesh/ears.hpp"
#include "fem/mesh/edge_uses.hpp"

#include <functional>
#include <limits>
#include <map>

namespace tactus::fem {

namespace {

constexpr std::size_t kMaxRing = 4096; ///< maximum number of edges of a hole to close
constexpr double kFlat = .02;          ///< distance of corners from the plane, relative to the
                                       ///< hole's extent
/// A surface with fewer triangles keeps its one large opening, since it may be a box or a cup that
/// is open on purpose. A surface with more triangles is a scan or a terrain without its bottom.
constexpr std::size_t kMinTriangles = 100;

/// Largest distance of a ring's corners from its mean plane (Newell's normal), m.
double off_plane(const std::vector<Vec3>& ring, const Vec3& centre) {
  Vec3 normal;
  for (std::size_t i = 0; i < ring.size(); ++i)
    normal += cross(ring[i] - centre, ring[(i + 1) % ring.size()] - centre);
  const double size = length(normal);
  if (!(size > 0))
    return std::numeric_limits<double>::infinity();
  double off = 0;
  for (const Vec3& p : ring)
    off = std::max(off, std::abs(dot(normal, p - centre)) / size);
  return off;
}

/// Edges with a triangle on one side only: start -> (end, triangle), directed opposite to the
/// orientation of that triangle.
using OpenEdges = std::map<int, std::pair<int, std::size_t>>;

/// The vertices of the ring of open edges through `start`; removes these edges from `next`.
std::vector<int> take_ring(OpenEdges& next, int start) {
  std::vector<int> ring;
  for (auto step = next.find(start); step != next.end(); step = next.find(ring.back())) {
    if (ring.empty())
      ring.push_back(start);
    const int to = step->second.first;
    next.erase(step);
    if (to == start)
      break;
    ring.push_back(to);
  }
  return ring;
}

/// Adds the triangles of a patch (indices into `ring`), in the group of the triangle `beside`.
void add_patch(Triangles& t, const std::vector<int>& ring,
               const std::vector<std::array<int, 3>>& patch, std::size_t beside) {
  for (const auto& ear : patch) {
    std::array<int, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k)
      triangle[k] = ring[static_cast<std::size_t>(ear[k])];
    t.triangles.push_back(triangle);
    if (!t.group.empty())
      t.group.push_back(t.group[beside]);
  }
}

} // namespace

std::vector<Hole> close_holes(Triangles& t, double area_share, double extent_share) {
  OpenEdges next;
  double skin = 0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    skin += .5 * length(t.normal(i));
  const auto uses = edge_uses(t);
  for_each_edge(uses, [&](auto first, auto last) {
    if (last - first == 1)
      next[first->forward ? first->b : first->a] = {first->forward ? first->a : first->b,
                                                    first->triangle};
  });
  const double size = bounding_box(t.points).largest();
  std::vector<Hole> holes;
  std::size_t large = 0, opening = 0;
  std::function<void()> close_opening; // closes the last large hole that is nearly plane
  while (!next.empty()) {
    const int start = next.begin()->first;
    const std::size_t beside = next.begin()->second.second;
    const std::vector<int> ring = take_ring(next, start);
    std::vector<Vec3> corners;
    Hole hole;
    for (const int v : ring) {
      corners.push_back(t.points[static_cast<std::size_t>(v)]);
      hole.centre += (1. / static_cast<double>(ring.size())) * corners.back();
    }
    hole.edges = ring.size();
    hole.extent = bounding_box(corners).largest();
    const auto patch =
        ring.size() <= kMaxRing ? clip_ears(corners) : std::vector<std::array<int, 3>>{};
    const auto at = [&](int i) { return corners[static_cast<std::size_t>(i)]; };
    for (const auto& [a, b, c] : patch)
      hole.area += .5 * length(cross(at(b) - at(a), at(c) - at(a)));
    const auto close = [&t, ring, patch, beside] { add_patch(t, ring, patch, beside); };
    hole.closed =
        !patch.empty() && hole.extent <= extent_share * size && hole.area <= area_share * skin;
    if (hole.closed) {
      close();
    } else {
      ++large;
      if (!patch.empty() && t.triangles.size() >= kMinTriangles &&
          off_plane(corners, hole.centre) <= kFlat * hole.extent) {
        opening = holes.size();
        close_opening = close;
      }
    }
    holes.push_back(hole);
  }
  if (large == 1 && close_opening) {
    close_opening();
    holes[opening].closed = holes[opening].flat_opening = true;
  }
  std::stable_sort(holes.begin(), holes.end(),
                   [](const Hole& a, const Hole& b) { return a.extent > b.extent; });
  return holes;
}

} // namespace tactus::fem

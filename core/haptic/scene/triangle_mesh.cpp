#include "core/haptic/scene/triangle_mesh.hpp"

#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace tactus::haptic {
namespace {

constexpr std::size_t kLeaf = 4;
constexpr int kDeepest = 62; // halving a span of 2^32 needs 32

struct Cell {
  std::int64_t x, y, z;
  friend bool operator==(const Cell&, const Cell&) = default;
};
struct CellHash {
  std::size_t operator()(const Cell& c) const noexcept {
    const auto mix = [](std::uint64_t h, std::int64_t v) {
      return (h ^ static_cast<std::uint64_t>(v)) * 0x9E3779B97F4A7C15ull;
    };
    return static_cast<std::size_t>(mix(mix(mix(0, c.x), c.y), c.z) >> 7);
  }
};

Vec3 lesser(const Vec3& a, const Vec3& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vec3 greater(const Vec3& a, const Vec3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

/// The signed volume that a way along `way` from the origin sees in an edge. The same edge the
/// other way round gives exactly the negative, whatever the rounding.
double side(const Vec3& way, const Vec3& a, const Vec3& b) noexcept {
  return way.x * (a.y * b.z - a.z * b.y) + way.y * (a.z * b.x - a.x * b.z) +
         way.z * (a.x * b.y - a.y * b.x);
}

/// Whether the way, seen as a box as well as a line, may touch the box before that share of it.
bool reaches(const Vec3& from, const Vec3& way, const Vec3& low, const Vec3& high,
             double share) noexcept {
  double begin = 0.0, end = share;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = low[axis] - from[axis], b = high[axis] - from[axis], w = way[axis];
    if (w == 0.0) {
      if (a > 0.0 || b < 0.0)
        return false;
      continue;
    }
    const double one = a / w, other = b / w;
    // A few ulp wider than computed: a box must not hide what lies on its face.
    begin = std::max(begin, std::min(one, other) * (1.0 - 4e-16));
    end = std::min(end, std::max(one, other) * (1.0 + 4e-16));
  }
  return begin <= end;
}

} // namespace

TriangleMesh::TriangleMesh(std::span<const Vec3> corners, std::span<const Triangle> triangles) {
  weld(corners, triangles);
  if (triangles_.empty())
    return;
  std::vector<Vec3> middles(triangles_.size());
  for (std::size_t i = 0; i < triangles_.size(); ++i)
    middles[i] =
        (corners_[triangles_[i][0]] + corners_[triangles_[i][1]] + corners_[triangles_[i][2]]) *
        (1.0 / 3.0);
  std::vector<std::uint32_t> order(triangles_.size());
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(triangles_.size());
  build(order, middles, 0, 0);
  std::vector<Triangle> sorted(triangles_.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    sorted[i] = triangles_[order[i]];
  triangles_ = std::move(sorted);
  low_ = nodes_[0].low;
  high_ = nodes_[0].high;
}

void TriangleMesh::weld(std::span<const Vec3> corners, std::span<const Triangle> triangles) {
  std::unordered_map<Cell, std::uint32_t, CellHash> cells;
  std::vector<std::uint32_t> place(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3& c = corners[i];
    const Cell cell{std::llround(c.x / kWeld_m), std::llround(c.y / kWeld_m),
                    std::llround(c.z / kWeld_m)};
    const auto found = cells.try_emplace(cell, static_cast<std::uint32_t>(corners_.size()));
    if (found.second)
      corners_.push_back(c);
    place[i] = found.first->second;
  }
  for (const Triangle& t : triangles) {
    if (t[0] >= place.size() || t[1] >= place.size() || t[2] >= place.size())
      continue;
    const Triangle welded{place[t[0]], place[t[1]], place[t[2]]};
    const Vec3 area =
        cross(corners_[welded[1]] - corners_[welded[0]], corners_[welded[2]] - corners_[welded[0]]);
    if (norm(area) > kWeld_m * kWeld_m)
      triangles_.push_back(welded);
  }
}

std::uint32_t TriangleMesh::build(std::span<std::uint32_t> order, std::span<const Vec3> middles,
                                  std::uint32_t first, int depth) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Vec3 low = corners_[triangles_[order[0]][0]], high = low;
  Vec3 middle_low = middles[order[0]], middle_high = middle_low;
  for (const std::uint32_t t : order) {
    for (const std::uint32_t corner : triangles_[t]) {
      low = lesser(low, corners_[corner]);
      high = greater(high, corners_[corner]);
    }
    middle_low = lesser(middle_low, middles[t]);
    middle_high = greater(middle_high, middles[t]);
  }
  nodes_[index].low = low;
  nodes_[index].high = high;
  const Vec3 extent = middle_high - middle_low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  if (order.size() <= kLeaf || depth >= kDeepest) {
    nodes_[index].first = first;
    nodes_[index].count = static_cast<std::uint32_t>(order.size());
    return index;
  }
  const std::size_t half = order.size() / 2;
  std::nth_element(
      order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
      [&](std::uint32_t a, std::uint32_t b) { return middles[a][axis] < middles[b][axis]; });
  build(order.first(half), middles, first, depth + 1);
  const std::uint32_t second =
      build(order.subspan(half), middles, first + static_cast<std::uint32_t>(half), depth + 1);
  nodes_[index].first = second;
  return index;
}

std::optional<Crossing> TriangleMesh::crossing(const Vec3& from, const Vec3& to) const noexcept {
  std::optional<Crossing> nearest;
  if (nodes_.empty())
    return nearest;
  const Vec3 way = to - from;
  double share = 1.0;
  std::array<std::uint32_t, kDeepest + 2> waiting;
  std::size_t count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const Node& node = nodes_[waiting[--count]];
    if (!reaches(from, way, node.low, node.high, share))
      continue;
    if (node.count == 0) {
      waiting[count++] = node.first;
      waiting[count++] = static_cast<std::uint32_t>(&node - nodes_.data()) + 1;
      continue;
    }
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
      const Vec3 a = corners_[triangles_[t][0]] - from, b = corners_[triangles_[t][1]] - from,
                 c = corners_[triangles_[t][2]] - from;
      const double u = side(way, a, b), v = side(way, b, c), w = side(way, c, a);
      if (!((u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0)))
        continue;
      Vec3 normal = cross(b - a, c - a);
      const double slope = dot(way, normal), height = dot(a, normal);
      if (slope == 0.0) // along the surface
        continue;
      const double at = height / slope;
      if (!(at >= 0.0 && at <= share))
        continue;
      if (slope > 0.0)
        normal = -normal;
      share = at;
      nearest = Crossing{at, normal * (1.0 / norm(normal))};
    }
  }
  return nearest;
}

} // namespace tactus::haptic

#include "core/haptic/scene/triangle_mesh.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <unordered_map>

namespace tactus::haptic {
namespace {

constexpr std::size_t kMaxLeafTriangles = 4;

/// Cell of the welding grid, of kWeld_m: corners in one cell are merged.
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

constexpr float kHuge = std::numeric_limits<float>::max();

/// Rounds to single precision, away from the box: towards -kHuge or kHuge.
float rounded(double value, float outwards) {
  return std::nextafter(static_cast<float>(value), outwards);
}

} // namespace

TriangleMesh::TriangleMesh(std::span<const Vec3> corners, std::span<const Triangle> triangles) {
  weld(corners, triangles);
  if (triangles_.empty())
    return;
  std::vector<Vec3> centroids(triangles_.size());
  for (std::size_t i = 0; i < triangles_.size(); ++i)
    centroids[i] =
        (corners_[triangles_[i][0]] + corners_[triangles_[i][1]] + corners_[triangles_[i][2]]) *
        (1.0 / 3.0);
  std::vector<std::uint32_t> order(triangles_.size());
  std::iota(order.begin(), order.end(), 0u);
  bounds_ = {corners_[triangles_[0][0]], corners_[triangles_[0][0]]};
  for (const Triangle& t : triangles_)
    for (const std::uint32_t corner : t)
      bounds_ = {lesser(bounds_.low, corners_[corner]), greater(bounds_.high, corners_[corner])};
  nodes_.reserve(triangles_.size());
  nodes_.emplace_back();
  plates_.reserve(triangles_.size());
  plates_.emplace_back();
  build(0, order, centroids, 0, 0);
  sort(order);
}

/// Sorts the triangles in the given order and the corners by their first use, so that neighbours in
/// space are neighbours in memory.
void TriangleMesh::sort(std::span<const std::uint32_t> order) {
  constexpr std::uint32_t kUnused = ~0u;
  std::vector<Triangle> triangles(order.size());
  std::vector<Vec3> corners;
  std::vector<std::uint32_t> new_index(corners_.size(), kUnused);
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& index = new_index[triangles_[order[i]][k]];
      if (index == kUnused) {
        index = static_cast<std::uint32_t>(corners.size());
        corners.push_back(corners_[triangles_[order[i]][k]]);
      }
      triangles[i][k] = index;
    }
  triangles_ = std::move(triangles);
  corners_ = std::move(corners);
}

void TriangleMesh::weld(std::span<const Vec3> corners, std::span<const Triangle> triangles) {
  std::unordered_map<Cell, std::uint32_t, CellHash> cells;
  std::vector<std::uint32_t> welded_index(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3& c = corners[i];
    const Cell cell{std::llround(c.x / kWeld_m), std::llround(c.y / kWeld_m),
                    std::llround(c.z / kWeld_m)};
    const auto found = cells.try_emplace(cell, static_cast<std::uint32_t>(corners_.size()));
    if (found.second)
      corners_.push_back(c);
    welded_index[i] = found.first->second;
  }
  for (const Triangle& t : triangles) {
    if (t[0] >= welded_index.size() || t[1] >= welded_index.size() || t[2] >= welded_index.size())
      continue;
    const Triangle welded{welded_index[t[0]], welded_index[t[1]], welded_index[t[2]]};
    const Vec3 area =
        cross(corners_[welded[1]] - corners_[welded[0]], corners_[welded[2]] - corners_[welded[0]]);
    if (norm(area) > kWeld_m * kWeld_m)
      triangles_.push_back(welded);
  }
}

TriangleMesh::Plate TriangleMesh::plate_around(std::span<const std::uint32_t> order) const {
  const auto single = [](const Vec3& v) {
    return std::array{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
  };
  const auto double_of = [](const std::array<float, 3>& v) { return Vec3{v[0], v[1], v[2]}; };
  Vec3 area, low = corners_[triangles_[order[0]][0]], high = low;
  for (const std::uint32_t t : order) {
    const Corners at = corners_of(t);
    area += cross(at.b - at.a, at.c - at.a);
    for (const Vec3& corner : {at.a, at.b, at.c}) {
      low = lesser(low, corner);
      high = greater(high, corner);
    }
  }
  Plate plate;
  const double length = norm(area);
  plate.axis = single(length > 0.0 ? area * (1.0 / length) : Vec3{0, 0, 1});
  const Vec3 axis = double_of(plate.axis), middle = (low + high) * 0.5;
  double below = 0, above = 0;
  for (const std::uint32_t t : order)
    for (const std::uint32_t corner : triangles_[t]) {
      const double height = dot(corners_[corner] - middle, axis);
      below = std::min(below, height);
      above = std::max(above, height);
    }
  plate.centre = single(middle + axis * (0.5 * (below + above)));
  const Vec3 centre = double_of(plate.centre);
  double half_thickness = 0, radius = 0;
  for (const std::uint32_t t : order)
    for (const std::uint32_t corner : triangles_[t]) {
      const Vec3 from_centre = corners_[corner] - centre;
      const double height = dot(from_centre, axis);
      half_thickness = std::max(half_thickness, std::abs(height));
      radius = std::max(radius, norm(from_centre - axis * height));
    }
  plate.half_thickness = rounded(half_thickness, kHuge);
  plate.radius = rounded(radius, kHuge);
  return plate;
}

/// Builds a node of the hierarchy over the triangles `order`: splits them at the median of their
/// centroids, along the longest extent of the centroids. first: index of order[0] among all
/// triangles.
void TriangleMesh::build(std::size_t node, std::span<std::uint32_t> order,
                         std::span<const Vec3> centroids, std::uint32_t first, int depth) {
  Vec3 low = corners_[triangles_[order[0]][0]], high = low;
  Vec3 centroid_low = centroids[order[0]], centroid_high = centroid_low;
  for (const std::uint32_t t : order) {
    for (const std::uint32_t corner : triangles_[t]) {
      low = lesser(low, corners_[corner]);
      high = greater(high, corners_[corner]);
    }
    centroid_low = lesser(centroid_low, centroids[t]);
    centroid_high = greater(centroid_high, centroids[t]);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    nodes_[node].low[i] = rounded(low[axis], -kHuge);
    nodes_[node].high[i] = rounded(high[axis], kHuge);
  }
  plates_[node] = plate_around(order);
  const Vec3 extent = centroid_high - centroid_low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  if (order.size() <= kMaxLeafTriangles || depth >= kMaxDepth) {
    nodes_[node].first = first;
    nodes_[node].count = static_cast<std::uint32_t>(order.size());
    return;
  }
  const std::size_t half = order.size() / 2;
  std::nth_element(
      order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
      [&](std::uint32_t a, std::uint32_t b) { return centroids[a][axis] < centroids[b][axis]; });
  const std::size_t child = nodes_.size();
  nodes_[node].first = static_cast<std::uint32_t>(child);
  nodes_.resize(child + 2);
  plates_.resize(child + 2);
  build(child, order.first(half), centroids, first, depth + 1);
  build(child + 1, order.subspan(half), centroids, first + static_cast<std::uint32_t>(half),
        depth + 1);
}

} // namespace tactus::haptic

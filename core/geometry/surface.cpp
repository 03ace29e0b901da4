#include "core/geometry/surface.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace tactus::modal {
namespace {

constexpr std::size_t kLeaf = 4;

/// Barycentric weights of the triangle's point nearest to p, by its Voronoi regions (Ericson,
/// Real-Time Collision Detection, 2005, section 5.1.5).
std::array<double, 3> nearest_weights(const std::array<Vec3, 3>& t, const Vec3& p) noexcept {
  const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0)
    return {1, 0, 0};
  const Vec3 bp = p - t[1];
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3)
    return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0)
    return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const Vec3 cp = p - t[2];
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6)
    return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0)
    return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) // a triangle without area
    return {1, 0, 0};
  return {va / sum, vb / sum, vc / sum};
}

Vec3 blend(const std::array<Vec3, 3>& t, const std::array<double, 3>& w) noexcept {
  return w[0] * t[0] + w[1] * t[1] + w[2] * t[2];
}

Vec3 normal_of(const std::array<Vec3, 3>& t) noexcept {
  const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
  const double size = norm(n);
  return size > 0 ? n * (1 / size) : Vec3{0, 0, 1};
}

} // namespace

void Surface::build(std::span<const Vec3> vertices,
                    std::span<const std::array<std::int32_t, 3>> triangles) {
  corner_.resize(triangles.size());
  order_.resize(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    order_[t] = static_cast<std::uint32_t>(t);
    for (std::size_t i = 0; i < 3; ++i)
      corner_[t][i] = vertices[static_cast<std::size_t>(triangles[t][i])];
  }
  boxes_.assign(1, {});
  boxes_.reserve(2 * triangles.size() / kLeaf + 2);
  if (!corner_.empty())
    split(0, 0, corner_.size());
}

void Surface::split(std::size_t box, std::size_t first, std::size_t last) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  Vec3 low{kHuge, kHuge, kHuge}, high{-kHuge, -kHuge, -kHuge};
  for (std::size_t i = first; i < last; ++i)
    for (const Vec3& c : corner_[order_[i]])
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], c[axis]);
        high[axis] = std::max(high[axis], c[axis]);
      }
  boxes_[box].low = low;
  boxes_[box].high = high;
  if (last - first <= kLeaf) {
    boxes_[box].first = static_cast<std::uint32_t>(first);
    boxes_[box].count = static_cast<std::uint32_t>(last - first);
    return;
  }
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (high[a] - low[a] > high[axis] - low[axis])
      axis = a;
  const auto centre = [&](std::uint32_t t) {
    return corner_[t][0][axis] + corner_[t][1][axis] + corner_[t][2][axis];
  };
  const std::size_t middle = (first + last) / 2;
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(first), at(middle), at(last), [&](std::uint32_t a, std::uint32_t b) {
    return centre(a) < centre(b) || (centre(a) == centre(b) && a < b);
  });
  const std::size_t child = boxes_.size();
  boxes_.resize(child + 2);
  boxes_[box].first = static_cast<std::uint32_t>(child);
  boxes_[box].count = 0;
  split(child, first, middle);
  split(child + 1, middle, last);
}

double Surface::distance_squared(const Box& box, const Vec3& point) noexcept {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double outside =
        std::max({box.low[axis] - point[axis], point[axis] - box.high[axis], 0.0});
    sum += outside * outside;
  }
  return sum;
}

SurfacePoint Surface::nearest(const Vec3& point) const noexcept {
  SurfacePoint best;
  double best_squared = std::numeric_limits<double>::infinity();
  // The tree is balanced: its depth is the logarithm of the number of triangles.
  std::array<std::uint32_t, 64> stack;
  std::size_t count = 0;
  stack[count++] = 0;
  while (count > 0) {
    const Box& box = boxes_[stack[--count]];
    if (distance_squared(box, point) > best_squared)
      continue;
    if (box.count == 0) {
      const bool right_first = distance_squared(boxes_[box.first + 1], point) <
                               distance_squared(boxes_[box.first], point);
      stack[count++] = box.first + (right_first ? 0 : 1);
      stack[count++] = box.first + (right_first ? 1 : 0);
      continue;
    }
    for (std::uint32_t i = box.first; i < box.first + box.count; ++i) {
      const auto& corners = corner_[order_[i]];
      const auto weight = nearest_weights(corners, point);
      const Vec3 position = blend(corners, weight);
      const Vec3 gap = position - point;
      const double squared = dot(gap, gap);
      // At equal distances the triangle with the lower number wins, so that the result does not
      // depend on the order of the search.
      if (squared < best_squared || (squared == best_squared && order_[i] < best.triangle)) {
        best_squared = squared;
        best.triangle = order_[i];
        best.weight = weight;
        best.position = position;
      }
    }
  }
  best.normal = normal_of(corner_[best.triangle]);
  best.distance = std::sqrt(best_squared);
  return best;
}

SurfacePoint Surface::on(std::size_t triangle, double u, double v) const noexcept {
  SurfacePoint point;
  point.triangle = triangle;
  point.weight = {1 - u - v, u, v};
  point.position = blend(corner_[triangle], point.weight);
  point.normal = normal_of(corner_[triangle]);
  return point;
}

double Surface::diagonal() const noexcept { return norm(boxes_[0].high - boxes_[0].low); }

Vec3 along_surface(const Vec3& normal, const Vec3& desired) noexcept {
  constexpr double kFacetSine = 0.342; // sine of 20 degrees
  constexpr double kMinTangent = 1e-3; // share of the desired length
  for (const Vec3& direction : {desired, Vec3{1, 0, 0}, Vec3{0, 1, 0}}) {
    const double length = norm(direction), off = dot(direction, normal);
    const Vec3 along = direction - off * normal;
    if (length > 0 && std::abs(off) < kFacetSine * length)
      return direction * (1 / length);
    if (const double tangent_length = norm(along); tangent_length > kMinTangent * length)
      return along * (1 / tangent_length);
  }
  return {1, 0, 0}; // no normal
}

} // namespace tactus::modal

#include "fem/mesh/crossing.hpp"

#include "fem/mesh/box_tree.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

/// Whether an interior point of segment p q lies in the interior of triangle a b c. False if
/// segment and triangle are coplanar up to rounding.
bool cuts(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const double size = std::max({length(q - p), length(b - a), length(c - a)});
  const double nothing = 1e-9 * size * size * size;
  const auto side = [&](const Vec3& x, const Vec3& y, const Vec3& z, const Vec3& w) {
    const double volume = dot(cross(y - x, z - x), w - x); // six times the tetrahedron's volume
    return volume > nothing ? 1 : volume < -nothing ? -1 : 0;
  };
  if (side(a, b, c, p) * side(a, b, c, q) >= 0)
    return false;
  const int turn = side(p, q, a, b);
  return turn != 0 && turn == side(p, q, b, c) && turn == side(p, q, c, a);
}

/// Whether two triangles with a common edge enclose an angle below 0.01 degrees, too small for an
/// element between them.
bool folded(const Triangles& t, std::size_t i, std::size_t j) {
  constexpr double kFlat = 1.5e-8; // 1 - cos(0.01 degrees)
  const Vec3 n = t.normal(i), m = t.normal(j);
  return dot(n, m) < -(1 - kFlat) * length(n) * length(m);
}

} // namespace

std::vector<Box> triangle_boxes(const Triangles& t) {
  std::vector<Box> boxes;
  boxes.reserve(t.triangles.size());
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    boxes.push_back(bounding_box(std::array{t.corner(i, 0), t.corner(i, 1), t.corner(i, 2)}));
  return boxes;
}

std::vector<std::array<std::size_t, 2>> crossings(const Triangles& t, std::size_t limit) {
  const std::vector<Box> boxes = triangle_boxes(t);
  const BoxTree tree(boxes);
  const auto pierces = [&](std::size_t i, std::size_t j) {
    for (std::size_t k = 0; k < 3; ++k)
      if (cuts(t.corner(i, k), t.corner(i, k + 1), t.corner(j, 0), t.corner(j, 1), t.corner(j, 2)))
        return true;
    return false;
  };
  std::vector<std::array<std::size_t, 2>> found;
  for (std::size_t i = 0; i < boxes.size() && found.size() < limit; ++i)
    tree.for_each_near(boxes[i], 0, [&](std::size_t j) {
      if (j <= i)
        return true;
      const auto &c = t.triangles[i], &d = t.triangles[j];
      const auto common = std::count_if(
          c.begin(), c.end(), [&](int v) { return std::find(d.begin(), d.end(), v) != d.end(); });
      if (common > 1 ? folded(t, i, j) : pierces(i, j) || pierces(j, i))
        found.push_back({i, j});
      return found.size() < limit;
    });
  return found;
}

std::optional<std::array<std::size_t, 2>> crossing(const Triangles& t) {
  const auto found = crossings(t, 1);
  return found.empty() ? std::nullopt : std::optional(found[0]);
}

} // namespace tactus::fem

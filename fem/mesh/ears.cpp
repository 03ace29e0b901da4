#include "fem/mesh/ears.hpp"

#include <cmath>
#include <numeric>

namespace tactus::fem {
namespace {

using Point2 = std::array<double, 2>;

double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Corners in the plane of the polygon's mean normal (Newell), turning to the left.
std::vector<Point2> flattened(std::span<const Vec3> corners) {
  Vec3 normal;
  for (std::size_t i = 0; i < corners.size(); ++i)
    normal += cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
  const double size = length(normal);
  normal = size > 0 ? (1 / size) * normal : Vec3{0, 0, 1};
  const Vec3 other = std::abs(normal.x) < .6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  Vec3 x = cross(other, normal);
  x = (1 / length(x)) * x;
  const Vec3 y = cross(normal, x);
  std::vector<Point2> flat;
  flat.reserve(corners.size());
  for (const Vec3& p : corners)
    flat.push_back({dot(x, p - corners[0]), dot(y, p - corners[0])});
  return flat;
}

} // namespace

std::vector<std::array<int, 3>> clip_ears(std::span<const Vec3> corners) {
  const std::vector<Point2> flat = flattened(corners);
  std::vector<int> left(corners.size());
  std::iota(left.begin(), left.end(), 0);
  std::vector<std::array<int, 3>> triangles;
  const auto at = [&](int i) -> const Point2& { return flat[static_cast<std::size_t>(i)]; };
  const auto is_ear = [&](int a, int b, int c) {
    if (!(turn(at(a), at(b), at(c)) > 0))
      return false;
    for (const int p : left) {
      if (p == a || p == b || p == c || at(p) == at(a) || at(p) == at(b) || at(p) == at(c))
        continue;
      if (turn(at(a), at(b), at(p)) >= 0 && turn(at(b), at(c), at(p)) >= 0 &&
          turn(at(c), at(a), at(p)) >= 0)
        return false;
    }
    return true;
  };
  while (left.size() > 3) {
    // Chooses the ear with the shortest new edge, since fans would leave slivers. If there are very
    // many corners, it takes the first ear, to limit the time.
    std::size_t best = left.size();
    double shortest = 0;
    for (std::size_t i = 0; i < left.size(); ++i) {
      const int a = left[i], b = left[(i + 1) % left.size()], c = left[(i + 2) % left.size()];
      const double size =
          length(corners[static_cast<std::size_t>(c)] - corners[static_cast<std::size_t>(a)]);
      if ((best == left.size() || size < shortest) && is_ear(a, b, c)) {
        best = i;
        shortest = size;
        if (left.size() > 200)
          break;
      }
    }
    if (best == left.size())
      best = 0; // takes any corner if the polygon crosses itself or has no area
    const std::size_t tip = (best + 1) % left.size();
    triangles.push_back({left[best], left[tip], left[(best + 2) % left.size()]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(tip));
  }
  if (left.size() == 3)
    triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

} // namespace tactus::fem

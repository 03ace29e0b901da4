#include "fem/mesh/distance.hpp"

#include <algorithm>

namespace tactus::fem {

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = cross(b - a, c - a);
  const double size = length(n);
  if (size > 0 && dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 &&
      dot(cross(a - c, p - c), n) >= 0)
    return std::abs(dot(n, p - a)) / size;
  const auto to_edge = [&](const Vec3& from, const Vec3& to) {
    const Vec3 along = to - from;
    const double share =
        std::clamp(dot(p - from, along) / std::max(dot(along, along), 1e-300), 0., 1.);
    return length(p - from - share * along);
  };
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

double distance_of_edges(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b) {
  const Vec3 u = q - p, v = b - a, n = cross(u, v);
  const double size = dot(n, n);
  if (!(size > 1e-20 * dot(u, u) * dot(v, v)))
    return 1e300; // for parallel edges, their ends give the distance
  const Vec3 w = a - p;
  const double s = dot(cross(w, v), n) / size, t = dot(cross(w, u), n) / size;
  if (s < 0 || s > 1 || t < 0 || t > 1)
    return 1e300;
  return std::abs(dot(w, n)) / std::sqrt(size);
}

} // namespace tactus::fem

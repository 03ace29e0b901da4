#pragma once
#include "fem/mesh/shells.hpp"
#include "fem/mesh/weld.hpp"

#include <array>
#include <numbers>
#include <vector>

namespace tactus::fem {

using Corners = std::array<Vec3, 3>;
/// Triangles each with corners of its own, as an STL has them.
using TriangleSoup = std::vector<Corners>;

inline TriangleSoup operator+(TriangleSoup a, const TriangleSoup& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// The same surface seen from its other side.
inline TriangleSoup turned(TriangleSoup soup) {
  for (Corners& c : soup)
    std::swap(c[0], c[1]);
  return soup;
}

inline TriangleSoup box(const Vec3& low, const Vec3& size) {
  static constexpr std::array kCorners{0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  const auto at = [&](int i) {
    return low + Vec3{i % 2 * size.x, i / 2 % 2 * size.y, double(i / 4) * size.z};
  };
  TriangleSoup out;
  for (std::size_t i = 0; i < kCorners.size(); i += 3)
    out.push_back({at(kCorners[i]), at(kCorners[i + 1]), at(kCorners[i + 2])});
  return out;
}

/// A ball of rings and twice as many meridians: slivers at its poles.
inline TriangleSoup sphere(const Vec3& centre, double radius, int rings) {
  const auto at = [&](int i, int j) {
    const double a = std::numbers::pi * i / rings, b = std::numbers::pi * j / rings;
    return centre +
           radius * Vec3{std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)};
  };
  TriangleSoup out;
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < 2 * rings; ++j) {
      if (i > 0)
        out.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < rings)
        out.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  return out;
}

inline Triangles surface(const TriangleSoup& soup) {
  Triangles t;
  for (const Corners& c : soup) {
    const int n = static_cast<int>(t.points.size());
    t.points.insert(t.points.end(), c.begin(), c.end());
    t.triangles.push_back({n, n + 1, n + 2});
  }
  return t;
}

/// Corners united; every edge must have its two triangles.
inline Triangles closed(const TriangleSoup& soup) {
  Triangles t = surface(soup);
  weld(t);
  close(t);
  return t;
}

inline double enclosed(const Triangles& t) {
  double sum = 0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    sum += dot(t.corner(i, 0), cross(t.corner(i, 1), t.corner(i, 2))) / 6;
  return sum;
}

} // namespace tactus::fem

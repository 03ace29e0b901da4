#include "fem/element/quadrature.hpp"

#include <vector>

namespace tactus::fem {
namespace {

using Points = std::vector<QuadraturePoint>;

Points tetrahedron_4() {
  const double root = std::sqrt(5.0), a = (5 + 3 * root) / 20, b = (5 - root) / 20, w = 1.0 / 24;
  return {{{b, b, b}, w}, {{a, b, b}, w}, {{b, a, b}, w}, {{b, b, a}, w}};
}

/// Degree 5: the centroid, two orbits of four points and one of six. The weights of the orbits are
/// closed forms in sqrt(15) (Stroud 1971, T3 5-1).
Points tetrahedron_15() {
  const double root = std::sqrt(15.0);
  Points points{{{.25, .25, .25}, 16.0 / 135 / 6}};
  for (const double sign : {-1.0, 1.0}) {
    const double a = (7 + sign * root) / 34, b = 1 - 3 * a;
    const double w = (2665 - sign * 14 * root) / 37800 / 6;
    for (const Vec3& p : {Vec3{a, a, a}, Vec3{b, a, a}, Vec3{a, b, a}, Vec3{a, a, b}})
      points.push_back({p, w});
  }
  const double c = (10 - 2 * root) / 40, d = .5 - c, w = 20.0 / 378 / 6;
  for (const Vec3& p :
       {Vec3{c, c, d}, Vec3{c, d, c}, Vec3{d, c, c}, Vec3{c, d, d}, Vec3{d, c, d}, Vec3{d, d, c}})
    points.push_back({p, w});
  return points;
}

struct LinePoint {
  double at, weight;
};

std::vector<LinePoint> line(int count) {
  if (count == 2)
    return {{-1 / std::sqrt(3.0), 1}, {1 / std::sqrt(3.0), 1}};
  const double x = std::sqrt(.6);
  return {{-x, 5.0 / 9}, {0, 8.0 / 9}, {x, 5.0 / 9}};
}

Points hexahedron(int count) {
  Points points;
  for (const LinePoint& i : line(count))
    for (const LinePoint& j : line(count))
      for (const LinePoint& k : line(count))
        points.push_back({{i.at, j.at, k.at}, i.weight * j.weight * k.weight});
  return points;
}

/// Six points of degree 4 on the triangle (Strang & Fix 1973; here from the closed form of Cowper
/// 1973) times three Gauss points.
Points wedge() {
  const double root10 = std::sqrt(10.0), root = std::sqrt(38 - 44 * std::sqrt(.4));
  const double wroot = std::sqrt(213125 - 53320 * root10);
  Points points;
  for (const double sign : {1.0, -1.0}) {
    const double a = (8 - root10 + sign * root) / 18, b = 1 - 2 * a;
    const double w = (620 + sign * wroot) / 3720 / 2;
    for (const LinePoint& k : line(3))
      for (const Vec3& p : {Vec3{a, a, k.at}, Vec3{b, a, k.at}, Vec3{a, b, k.at}})
        points.push_back({p, w * k.weight});
  }
  return points;
}

/// The points of a hexahedron whose upper face is collapsed to the apex: t = (1 + z) / 2, and r and
/// s shrink with 1 - t.
Points pyramid(int count) {
  Points points = hexahedron(count);
  for (QuadraturePoint& q : points) {
    const double t = .5 * (1 + q.at.z), h = 1 - t;
    q = {{h * q.at.x, h * q.at.y, t}, .5 * h * h * q.weight};
  }
  return points;
}

} // namespace

std::span<const QuadraturePoint> stiffness_points(Shape shape) {
  static const Points one{{{.25, .25, .25}, 1.0 / 6}};
  static const Points four = tetrahedron_4();
  static const Points eight = hexahedron(2);
  static const Points collapsed = pyramid(2);
  switch (shape) {
  case Shape::tet4:
    return one;
  case Shape::tet10:
    return four;
  case Shape::hex8:
    return eight;
  case Shape::pyramid5:
    return collapsed;
  case Shape::hex20:
  case Shape::wedge15:
  case Shape::wedge6:
    break;
  }
  return mass_points(shape);
}

std::span<const QuadraturePoint> mass_points(Shape shape) {
  static const Points four = tetrahedron_4();
  static const Points fifteen = tetrahedron_15();
  static const Points twenty_seven = hexahedron(3);
  static const Points eighteen = wedge();
  static const Points collapsed = pyramid(3);
  switch (shape) {
  case Shape::tet4:
    return four;
  case Shape::tet10:
    return fifteen;
  case Shape::hex8:
  case Shape::hex20:
    return twenty_seven;
  case Shape::pyramid5:
    return collapsed;
  case Shape::wedge15:
  case Shape::wedge6:
    break;
  }
  return eighteen;
}

} // namespace tactus::fem

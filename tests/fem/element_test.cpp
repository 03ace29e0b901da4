#include "fem/element/jacobian.hpp"
#include "fem/element/matrices.hpp"
#include "fem/element/quadrature.hpp"
#include "fem/shapes/shapes.hpp"
#include "solve.hpp"
#include "tetrahedra.hpp"

#include <algorithm>

using namespace tactus::fem;
using tactus::Vec3;

namespace {
constexpr std::array kAllShapes{Shape::tet4,    Shape::tet10,  Shape::hex8,    Shape::hex20,
                                Shape::wedge15, Shape::wedge6, Shape::pyramid5};

/// A point inside every reference element.
constexpr Vec3 kInside{.21, .17, .23};

/// Of x^i y^j z^k over the reference element.
double integral(std::span<const QuadraturePoint> points, int i, int j, int k) {
  double sum = 0;
  for (const QuadraturePoint& q : points)
    sum += q.weight * std::pow(q.at.x, i) * std::pow(q.at.y, j) * std::pow(q.at.z, k);
  return sum;
}

double factorial(int n) { return n < 2 ? 1 : n * factorial(n - 1); }
} // namespace

TEST_CASE(
    "shape functions are one at their node and zero at others, sum to one, and their slopes are "
    "their differences") {
  ShapeValues at, above, below;
  constexpr double kStep = 1e-5;
  for (const Shape shape : kAllShapes) {
    const auto nodes = reference_nodes(shape);
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      evaluate(shape, nodes[a], at);
      for (std::size_t b = 0; b < nodes.size(); ++b)
        CHECK(at.value[b] == doctest::Approx(a == b ? 1 : 0).epsilon(1e-14));
    }
    evaluate(shape, kInside, at);
    double sum = 0;
    for (std::size_t a = 0; a < nodes.size(); ++a)
      sum += at.value[a];
    CHECK(sum == doctest::Approx(1).epsilon(1e-14));
    for (int k = 0; k < 3; ++k) {
      Vec3 step;
      step[k] = kStep;
      evaluate(shape, kInside + step, above);
      evaluate(shape, kInside - step, below);
      for (std::size_t a = 0; a < nodes.size(); ++a) // of cubics: right to the step squared
        CHECK(std::abs((above.value[a] - below.value[a]) / (2 * kStep) - at.derivative[a][k]) <
              1e-9);
    }
  }
}

TEST_CASE("mass points integrate every monomial up to their degree, weights sum to the volume") {
  // The unit tetrahedron: i! j! k! / (i + j + k + 3)!
  for (int i = 0; i <= 5; ++i)
    for (int j = 0; i + j <= 5; ++j)
      for (int k = 0; i + j + k <= 5; ++k)
        CHECK(integral(mass_points(Shape::tet10), i, j, k) ==
              doctest::Approx(factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3))
                  .epsilon(1e-13));
  // The wedge: degree four in the triangle and five along it.
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; i + j <= 4; ++j)
      for (int k = 0; k <= 5; ++k)
        CHECK(std::abs(integral(mass_points(Shape::wedge15), i, j, k) -
                       factorial(i) * factorial(j) / factorial(i + j + 2) *
                           (k % 2 ? 0 : 2.0 / (k + 1))) < 1e-14);
  for (const auto& [shape, volume] : {std::pair{Shape::tet4, 1. / 6},
                                      {Shape::tet10, 1. / 6},
                                      {Shape::hex8, 8.},
                                      {Shape::hex20, 8.},
                                      {Shape::wedge15, 1.},
                                      {Shape::wedge6, 1.},
                                      {Shape::pyramid5, 4. / 3}})
    for (const auto& points : {mass_points(shape), stiffness_points(shape)})
      CHECK(integral(points, 0, 0, 0) == doctest::Approx(volume).epsilon(1e-14));
}

TEST_CASE("every face's normal points out of the element") {
  for (const Shape shape : kAllShapes) {
    const auto nodes = reference_nodes(shape);
    Vec3 middle;
    for (const Vec3& p : nodes)
      middle += (1.0 / static_cast<double>(nodes.size())) * p;
    for (const Face& face : faces(shape)) {
      const auto at = [&](std::size_t i) { return nodes[static_cast<std::size_t>(face.node[i])]; };
      CHECK(dot(cross(at(1) - at(0), at(2) - at(0)), at(0) - middle) > 0);
      if (is_linear(shape))
        continue;
      for (std::size_t c = 0; c < static_cast<std::size_t>(face.corners);
           ++c) { // edge nodes halve the edges
        const auto corners = static_cast<std::size_t>(face.corners);
        const Vec3 gap = at(corners + c) - .5 * (at(c) + at((c + 1) % corners));
        CHECK(length(gap) < 1e-14);
      }
    }
  }
}

TEST_CASE("an isotropic solid given by nine constants is the isotropic solid") {
  const Material a = find_material("aluminium");
  Material b = a;
  const double e = a.young_pa[0], nu = a.poisson[0], g = e / (2 * (1 + nu));
  b.young_pa = {e, e, e};
  b.poisson = {nu, nu, nu};
  b.shear_pa = {g, g, g};
  b.axis_1 = {1, 2, -1};
  b.axis_2 = {0, 1, 3};
  const ElasticMatrix ca = elastic_matrix(a), cb = elastic_matrix(b);
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      CHECK(std::abs(ca[i][j] - cb[i][j]) < 1e-13 * ca[0][0]);
}

TEST_CASE("materials that would release energy are refused by name") {
  Material m = find_material("spruce");
  m.poisson = {1.9, 1.9, 1.9};
  check_refused([&] { return elastic_matrix(m); }, "spruce");
  m = find_material("steel");
  m.poisson[0] = .5;
  check_refused([&] { return elastic_matrix(m); }, "0.5");
  check_refused([] { return find_material("cheese"); }, "expected one of");
}

TEST_CASE("low faces on a curved wall do not tilt its skin") {
  // Rows graded to the cavity's edge are lower than the wall bulges between their corners.
  const Mesh mesh = make_shape(
      "hollow_disk",
      {{"diameter", .1}, {"thickness", .025}, {"cavity_diameter", .08}, {"cavity_thickness", .013}},
      {}, {});
  const Surface skin = surface_of(mesh);
  const auto at = [&](int v) {
    return mesh.nodes[static_cast<std::size_t>(skin.node[static_cast<std::size_t>(v)])];
  };
  int walls = 0;
  for (const auto& [a, b, c] : skin.triangles) {
    const auto on_wall = [&](int v) { return std::hypot(at(v).x, at(v).y) > .0499; };
    const Vec3 normal = cross(at(b) - at(a), at(c) - at(a));
    if (!on_wall(a) || !on_wall(b) || !on_wall(c) || std::abs(normal.z) > .999 * length(normal))
      continue; // the rim's own corners on the flat faces
    ++walls;
    CHECK(std::abs(normal.z) < .01 * length(normal));
  }
  CHECK(walls > 500);
}

TEST_CASE("a side whose curve turns an element inside out is flattened, and no other") {
  Mesh mesh = tetrahedral_block(2, true);
  CHECK(has_straight_sides(mesh));
  const auto node_at = [&](const Vec3& p) {
    std::size_t i = 0;
    while (length(mesh.nodes[i] - p) > 1e-9)
      ++i;
    return i;
  };
  const std::size_t mild = node_at({.25, 0, 1}), wild = node_at({.75, 1, 1});
  mesh.nodes[mild].z = 1.02;
  CHECK(!has_straight_sides(mesh));
  CHECK(straighten_inverted(mesh) == 0);
  mesh.nodes[wild].z = .7;
  double min_determinant = 1;
  for (const Element& e : mesh.elements)
    min_determinant = std::min(min_determinant, min_jacobian(mesh, e));
  CHECK(min_determinant < 0);
  CHECK_THROWS_AS(check(mesh), InputError);
  CHECK(straighten_inverted(mesh) == 1);
  CHECK_NOTHROW(check(mesh));
  // The bend of .3 is halved until the element is sound, no further.
  CHECK(std::abs(mesh.nodes[wild].z - 1) <= .1501);
  CHECK(std::abs(mesh.nodes[wild].z - 1) >= .0749);
  CHECK(mesh.nodes[mild].z == 1.02);
  for (const Element& e : mesh.elements)
    CHECK(e.shape == Shape::tet10);
}

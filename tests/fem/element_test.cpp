#include "fem/element/jacobian.hpp"
#include "fem/element/matrices.hpp"
#include "fem/element/quadrature.hpp"
#include "fem/shapes/ball.hpp"
#include "fem/shapes/section.hpp"
#include "fem/shapes/shapes.hpp"
#include "solve.hpp"
#include "tetrahedra.hpp"

#include <algorithm>

using namespace tactus::fem;

namespace {
constexpr std::array kShapes{Shape::tet4, Shape::tet10, Shape::hex8, Shape::hex20, Shape::wedge15};

/// A point inside every reference element.
constexpr Vector3 kInside{.21, .17, .23};

double reference_volume(Shape shape) {
  return shape == Shape::tet4 || shape == Shape::tet10 ? 1.0 / 6
         : shape == Shape::wedge15                     ? 1.0
                                                       : 8.0;
}

double monomial(const Vector3& p, int i, int j, int k) {
  return std::pow(p.x, i) * std::pow(p.y, j) * std::pow(p.z, k);
}

double factorial(int n) { return n < 2 ? 1 : n * factorial(n - 1); }
} // namespace

TEST_CASE("a shape function is one at its node and zero at the others") {
  ShapeValues values;
  for (const Shape shape : kShapes) {
    const auto nodes = reference_nodes(shape);
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      evaluate(shape, nodes[a], values);
      for (std::size_t b = 0; b < nodes.size(); ++b)
        CHECK(values.value[b] == doctest::Approx(a == b ? 1 : 0).epsilon(1e-14));
    }
  }
}

TEST_CASE("shape functions sum to one and their slopes are their differences") {
  ShapeValues at, above, below;
  constexpr double kStep = 1e-5;
  for (const Shape shape : kShapes) {
    evaluate(shape, kInside, at);
    const auto count = static_cast<std::size_t>(node_count(shape));
    double sum = 0;
    for (std::size_t a = 0; a < count; ++a)
      sum += at.value[a];
    CHECK(sum == doctest::Approx(1).epsilon(1e-14));
    for (int k = 0; k < 3; ++k) {
      Vector3 step;
      step[k] = kStep;
      evaluate(shape, kInside + step, above);
      evaluate(shape, kInside - step, below);
      for (std::size_t a = 0; a < count; ++a) // differences of cubics: right to the step squared
        CHECK(std::abs((above.value[a] - below.value[a]) / (2 * kStep) - at.derivative[a][k]) <
              1e-9);
    }
  }
}

TEST_CASE("the tetrahedron's mass points integrate every monomial up to degree five") {
  // Integral over the unit tetrahedron: i! j! k! / (i+j+k+3)!
  for (int i = 0; i <= 5; ++i)
    for (int j = 0; i + j <= 5; ++j)
      for (int k = 0; i + j + k <= 5; ++k) {
        double sum = 0;
        for (const QuadraturePoint& q : mass_points(Shape::tet10))
          sum += q.weight * monomial(q.at, i, j, k);
        const double exact = factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3);
        CHECK(sum == doctest::Approx(exact).epsilon(1e-13));
      }
}

TEST_CASE("the wedge's points integrate degree four in the triangle and five along it") {
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; i + j <= 4; ++j)
      for (int k = 0; k <= 5; ++k) {
        double sum = 0;
        for (const QuadraturePoint& q : mass_points(Shape::wedge15))
          sum += q.weight * monomial(q.at, i, j, k);
        const double exact =
            factorial(i) * factorial(j) / factorial(i + j + 2) * (k % 2 ? 0 : 2.0 / (k + 1));
        CHECK(std::abs(sum - exact) < 1e-14);
      }
}

TEST_CASE("weights sum to the reference volume") {
  for (const Shape shape : kShapes)
    for (const auto& points : {mass_points(shape), stiffness_points(shape)}) {
      double sum = 0;
      for (const QuadraturePoint& q : points)
        sum += q.weight;
      CHECK(sum == doctest::Approx(reference_volume(shape)).epsilon(1e-14));
    }
}

TEST_CASE("every face's normal points out of the element") {
  for (const Shape shape : kShapes) {
    const auto nodes = reference_nodes(shape);
    Vector3 middle;
    for (const Vector3& p : nodes)
      middle += (1.0 / static_cast<double>(nodes.size())) * p;
    for (const Face& face : faces(shape)) {
      const auto at = [&](std::size_t i) { return nodes[static_cast<std::size_t>(face.node[i])]; };
      CHECK(dot(cross(at(1) - at(0), at(2) - at(0)), at(0) - middle) > 0);
      if (is_linear(shape))
        continue;
      for (std::size_t c = 0; c < static_cast<std::size_t>(face.corners);
           ++c) { // edge nodes halve the edges
        const auto corners = static_cast<std::size_t>(face.corners);
        const Vector3 gap = at(corners + c) - .5 * (at(c) + at((c + 1) % corners));
        CHECK(length(gap) < 1e-14);
      }
    }
  }
}

namespace {

/// Wedges round the axis, hexahedra outside.
Mesh turned_disk() {
  return plan_shape("disk", {{"diameter", 2}, {"thickness", .6}}, {}, {.h = .4}).make().mesh;
}

} // namespace

TEST_CASE("a constant strain leaves every inner node of a distorted mesh without force") {
  // The patch test: a quadratic element with straight sides, however skewed, holds linear fields.
  const Material wood = find_material("spruce");
  std::vector<Mesh> meshes;
  meshes.push_back(tetrahedral_block(3, true));
  meshes.push_back(tetrahedral_block(3, false));
  meshes.push_back(make_ball(1, .5, 2).mesh);
  meshes.push_back(turned_disk());
  for (Mesh& mesh : meshes) {
    CAPTURE(mesh.element_names());
    const bool round = mesh.element_names().find("hex") != std::string::npos;
    if (!round) // shear and stretch the block unevenly
      for (Vector3& p : mesh.nodes)
        p = {p.x + .3 * p.y - .2 * p.z, p.y + .1 * p.x, 1.4 * p.z + .2 * p.y};
    check(mesh);
    const Matrices m = assemble(mesh, std::span(&wood, 1), {});
    std::vector<double> u(m.dofs()), force(m.dofs());
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
      const Vector3& p = mesh.nodes[i];
      u[3 * i] = 1e-3 * (2 * p.x - p.y + .5 * p.z);
      u[3 * i + 1] = 1e-3 * (p.x + 3 * p.y - p.z);
      u[3 * i + 2] = 1e-3 * (.5 * p.x + p.y + p.z);
    }
    m.multiply_stiffness(u, force, 1);
    double inner = 0, outer = 0;
    // On the skin forces balance the stress; inside they vanish.
    std::vector<bool> skin(mesh.nodes.size());
    for (const int n : outer_nodes(mesh))
      skin[static_cast<std::size_t>(n)] = true;
    for (std::size_t i = 0; i < force.size(); ++i)
      (skin[i / 3] ? outer : inner) = std::max(skin[i / 3] ? outer : inner, std::abs(force[i]));
    CHECK(outer > 0);
    // Curved sides are mapped by products of the coordinates, which linear fields survive exactly,
    // but their integrals are not exact: the tolerance of ball and disk is the quadrature's.
    CHECK(inner < (round ? 2e-3 : 1e-12) * outer);
  }
}

TEST_CASE("a rigid turn costs no energy in any element") {
  const Material metal = find_material("steel");
  for (Mesh mesh : {tetrahedral_block(2, true), make_ball(1, .5, 2).mesh, turned_disk()}) {
    const Matrices m = assemble(mesh, std::span(&metal, 1), {});
    std::vector<double> turn(m.dofs()), force(m.dofs());
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
      const Vector3 u = cross({.3, -.5, .7}, mesh.nodes[i]);
      for (int k = 0; k < 3; ++k)
        turn[3 * i + static_cast<std::size_t>(k)] = u[k];
    }
    m.multiply_stiffness(turn, force, 1);
    for (const double f : force)
      CHECK(std::abs(f) < 1e-12 * 200e9);
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
  const Mesh mesh = tetrahedral_block(2, true);
  const Matrices ma = assemble(mesh, std::span(&a, 1), {}),
                 mb = assemble(mesh, std::span(&b, 1), {});
  for (std::size_t i = 0; i < ma.stiffness.size(); ++i)
    CHECK(std::abs(ma.stiffness[i] - mb.stiffness[i]) < 1e-12 * e);
}

TEST_CASE("materials that would release energy are refused by name") {
  Material m = find_material("spruce");
  m.poisson = {1.9, 1.9, 1.9};
  CHECK_THROWS_WITH_AS((void)elastic_matrix(m), doctest::Contains("spruce"), InputError);
  m = find_material("steel");
  m.poisson[0] = .5;
  CHECK_THROWS_WITH_AS((void)elastic_matrix(m), doctest::Contains("0.5"), InputError);
  CHECK_THROWS_WITH_AS((void)find_material("cheese"), doctest::Contains("expected one of"),
                       InputError);
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
    const bool on_wall = std::hypot(at(a).x, at(a).y) > .0499 &&
                         std::hypot(at(b).x, at(b).y) > .0499 &&
                         std::hypot(at(c).x, at(c).y) > .0499;
    const Vector3 normal = cross(at(b) - at(a), at(c) - at(a));
    if (!on_wall || std::abs(normal.z) > .999 * length(normal))
      continue; // the rim's own corners on the flat faces
    ++walls;
    CHECK(std::abs(normal.z) < .01 * length(normal));
  }
  CHECK(walls > 500);
}

TEST_CASE("a side whose curve turns an element inside out is flattened, and no other") {
  Mesh mesh = tetrahedral_block(2, true);
  CHECK(has_straight_sides(mesh));
  const auto node_at = [&](const Vector3& p) {
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

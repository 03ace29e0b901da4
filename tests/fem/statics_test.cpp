#include "fem/shapes/shapes.hpp"
#include "static_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

using namespace tactus::fem;

namespace {

/// u = H x everywhere on the skin: the linear field that every element must hold inside.
constexpr std::array<std::array<double, 3>, 3> kStrain{
    {{1e-3, 2e-4, -3e-4}, {4e-4, -5e-4, 6e-4}, {-2e-4, 1e-4, 8e-4}}};
Vector3 linear_field(const Vector3& p) {
  Vector3 u;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      u[i] += kStrain[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] * p[j];
  return u;
}

/// Moves inner nodes; straight sides stay straight.
void distort(Mesh& mesh, double by) {
  std::vector<std::uint8_t> fixed(mesh.nodes.size(), 0);
  for (const int n : outer_nodes(mesh))
    fixed[static_cast<std::size_t>(n)] = 1;
  std::vector<std::uint8_t> corner(mesh.nodes.size(), 0);
  for (const Element& e : mesh.elements)
    for (int c = 0; c < corner_count(e.shape); ++c)
      corner[static_cast<std::size_t>(mesh.nodes_of(e)[static_cast<std::size_t>(c)])] = 1;
  unsigned state = 1;
  const auto random = [&] {
    state = state * 1664525U + 1013904223U;
    return state / 2147483648.0 - 1;
  };
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (corner[n] && !fixed[n])
      mesh.nodes[n] += by * Vector3{random(), random(), random()};
  for (const Element& e : mesh.elements) { // edge nodes back to the middle of their corners
    const auto reference = reference_nodes(e.shape);
    const auto nodes = mesh.nodes_of(e);
    const auto corners = static_cast<std::size_t>(corner_count(e.shape));
    for (std::size_t m = corners; m < nodes.size(); ++m)
      for (std::size_t a = 0; a < corners; ++a)
        for (std::size_t b = 0; b < a; ++b)
          if (length(.5 * (reference[a] + reference[b]) - reference[m]) < 1e-9)
            mesh.nodes[static_cast<std::size_t>(nodes[m])] =
                .5 * (mesh.nodes[static_cast<std::size_t>(nodes[a])] +
                      mesh.nodes[static_cast<std::size_t>(nodes[b])]);
  }
}

void check_constant_strain(const Mesh& mesh, const Material& material) {
  check(mesh);
  StaticModel model;
  model.materials = {material};
  for (const int n : outer_nodes(mesh))
    model.fixed.push_back(
        {"skin", {n}, {true, true, true}, linear_field(mesh.nodes[static_cast<std::size_t>(n)])});
  const StaticAnalysis analysis = solve_static(mesh, model);
  double worst = 0, size = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    for (int i = 0; i < 3; ++i) {
      const double exact = linear_field(mesh.nodes[n])[i];
      worst =
          std::max(worst, std::abs(analysis.solution.displacement[3 * n + std::size_t(i)] - exact));
      size = std::max(size, std::abs(exact));
    }
  CHECK(worst < 1e-10 * size);
  const auto stress = element_stress(mesh, model.materials, analysis.solution.displacement);
  const auto nodal = nodal_stress(mesh, model.materials, analysis.solution.displacement);
  const ElasticMatrix c = elastic_matrix(material);
  const auto& h = kStrain;
  const std::array<double, 6> strain{h[0][0],           h[1][1],           h[2][2],
                                     h[1][2] + h[2][1], h[0][2] + h[2][0], h[0][1] + h[1][0]};
  Stress exact{};
  for (std::size_t v = 0; v < 6; ++v)
    for (std::size_t w = 0; w < 6; ++w)
      exact[v] += c[v][w] * strain[w];
  const double scale = von_mises(exact);
  for (const auto* list : {&stress, &nodal})
    for (const Stress& s : *list)
      for (std::size_t v = 0; v < 6; ++v)
        REQUIRE(std::abs(s[v] - exact[v]) < 1e-10 * scale);
}

Material spruce() {
  Material m;
  m.name = "spruce";
  m.density = 450;
  m.young_pa = {11e9, 0.8e9, 0.45e9};
  m.poisson = {0.44, 0.38, 0.36};
  m.shear_pa = {0.04e9, 0.6e9, 0.75e9};
  m.axis_1 = {1, 1, 0};
  m.axis_2 = {-1, 1, 0};
  return m;
}

} // namespace

TEST_CASE("constant strain is exact on distorted elements of every shape") {
  Mesh tets = tetrahedral_block(3, true), linear = tetrahedral_block(3, false);
  distort(tets, .07);
  distort(linear, .07);
  Mesh bricks = block(even(0, 1, 3), even(0, 1, 3), even(0, 1, 3));
  distort(bricks, .07);
  for (const Material& m : {steel(), spruce()}) {
    check_constant_strain(tets, m);
    check_constant_strain(linear, m);
    check_constant_strain(bricks, m);
    // Wedges about the axis and curved bricks around them.
    check_constant_strain(make_shape("disk", {{"diameter", .1}, {"thickness", .03}}, {}, {.02}), m);
  }
}

TEST_CASE("a cantilever without Poisson's contraction bends as Timoshenko's beam") {
  // F L^3 / 3 E I + F L / (kappa A G), kappa = 5/6.
  const double e = 2.1e11, inertia = std::pow(.02, 4) / 12, shear = e / 2;
  const double theory = 100 * .008 / (3 * e * inertia) + 100 * .2 / (5. / 6 * .0004 * shear);
  // Where the wall and the even load keep the ends from warping, the solid is 9.6e-6 softer than
  // the beam: the limit of 8, 16 and 32 elements over the height (8.7e-6, 9.5e-6, 9.65e-6).
  const Cantilever beam(block(even(0, .2, 80), even(0, .02, 1), even(0, .02, 8)), 0);
  const auto analysis = solve_static(beam.mesh, beam.model);
  CHECK(beam.tip(analysis.solution.displacement) / theory - 1 ==
        doctest::Approx(9.65e-6).epsilon(.15));
  const Cantilever tets(Cantilever::tetrahedra(), 0);
  const auto u = solve_static(tets.mesh, tets.model).solution.displacement;
  check_close(tets.tip(u), theory, 7e-6);
  double mean = 0;
  const auto nodes = nodes_on(tets.mesh, 0, .2);
  for (const int n : nodes)
    mean -= u[3 * static_cast<std::size_t>(n) + 2] / static_cast<double>(nodes.size());
  check_close(mean, theory, 1e-6); // the figure of another program for the mean over nodes
}

TEST_CASE("a clamped steel cantilever is a little stiffer than Timoshenko's beam") {
  const Cantilever beam(Cantilever::tetrahedra(), .3);
  const double e = 2.1e11, inertia = std::pow(.02, 4) / 12, shear = e / 2.6, nu = .3;
  const double kappa = 10 * (1 + nu) / (12 + 11 * nu); // Cowper 1966
  const double theory = 100 * .008 / (3 * e * inertia) + 100 * .2 / (kappa * .0004 * shear);
  const auto analysis = solve_static(beam.mesh, beam.model);
  const auto& u = analysis.solution.displacement;
  check_close(beam.tip(u), theory, .01);
  check_close(beam.tip(u), 9.5265e-5, 1e-3); // another program's tet10, 49 600 unknowns
  // Clapeyron: the strain energy is half the work of the loads.
  double work = 0;
  for (std::size_t i = 0; i < u.size(); ++i)
    work += analysis.system.load[i] * u[i];
  check_close(analysis.solution.strain_energy, work / 2, 1e-10);
  // Bending stress M z / I in the outer fibres, away from both ends.
  const auto stress = element_stress(beam.mesh, beam.model.materials, u);
  double worst = 0;
  int compared = 0;
  for (std::size_t k = 0; k < stress.size(); ++k) {
    Vector3 middle;
    for (std::size_t c = 0; c < 4; ++c)
      middle +=
          .25 *
          beam.mesh.nodes[static_cast<std::size_t>(beam.mesh.nodes_of(beam.mesh.elements[k])[c])];
    const double z = middle.z - .01;
    if (middle.x < .04 || middle.x > .16 || std::abs(z) < .006)
      continue;
    const double bending = 100 * (.2 - middle.x) * std::abs(z) / inertia;
    worst = std::max(worst, std::abs(von_mises(stress[k]) / bending - 1));
    ++compared;
  }
  CHECK(compared > 300);
  CHECK(worst < .031);
}

TEST_CASE("a round hole in a wide plate raises the stress three times") {
  // Kirsch 1898, in plane strain (a free plate's stress varies through its thickness, by 5 % in one
  // as thick as this). The plate is 60 diameters wide: Howland's correction is below 0.1 %.
  const double a = .01, b = 60 * a, thickness = .004;
  Mesh mesh = quarter_plate(a, b, thickness, true, 22, 12, 1.35);
  StaticModel model;
  model.materials = {steel()};
  model.fixed = {{"x", select_nodes(mesh, plane(0, 0)), {true, false, false}, {}},
                 {"y", select_nodes(mesh, plane(1, 0)), {false, true, false}, {}},
                 {"z", select_nodes(mesh, plane(2, 0)), {false, false, true}, {}},
                 {"far z", select_nodes(mesh, plane(2, thickness)), {false, false, true}, {}}};
  model.loads = {Traction{"pull", select_faces(mesh, plane(0, b)), {1e6, 0, 0}}};
  const auto analysis = solve_static(mesh, model);
  const auto stress = nodal_stress(mesh, model.materials, analysis.solution.displacement);
  int found = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (length(mesh.nodes[n] - Vector3{0, a, mesh.nodes[n].z}) < 1e-9) {
      CHECK(stress[n][0] / 1e6 == doctest::Approx(3.00).epsilon(.01));
      ++found;
    }
    if (length(mesh.nodes[n] - Vector3{a, 0, mesh.nodes[n].z}) < 1e-9) {
      CHECK(stress[n][1] / 1e6 == doctest::Approx(-1.00).epsilon(.02));
      ++found;
    }
  }
  CHECK(found == 6);
  // And at one radius from the edge: sigma (2 + (a/r)^2 + 3 (a/r)^4) / 2 over the hole.
  double nearest = 1;
  Stress there{};
  double r = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (mesh.nodes[n].x == 0 && std::abs(mesh.nodes[n].y - 2 * a) < nearest) {
      nearest = std::abs(mesh.nodes[n].y - 2 * a);
      there = stress[n];
      r = mesh.nodes[n].y;
    }
  const double q = a / r * a / r;
  check_close(there[0], 1e6 * (2 + q + 3 * q * q) / 2, .01);
}

TEST_CASE("a thick tube under pressure yields as Lame's") {
  const double a = .05, b = .1, p = 1e7, nu = .3, e = 2.1e11;
  std::vector<double> errors;
  for (const int fine : {1, 2}) {
    Mesh mesh = quarter_plate(a, b, .01, false, 4 * fine, 6 * fine, 1.01);
    StaticModel model;
    model.materials = {steel(nu)};
    model.fixed = {{"x", select_nodes(mesh, plane(0, 0)), {true, false, false}, {}},
                   {"y", select_nodes(mesh, plane(1, 0)), {false, true, false}, {}},
                   {"low", select_nodes(mesh, plane(2, 0)), {false, false, true}, {}},
                   {"high", select_nodes(mesh, plane(2, .01)), {false, false, true}, {}}};
    model.loads = {Pressure{
        "bore", select_faces(mesh, {OnCylinder{{0, 0, -1}, {0, 0, 1}, a, false}, 1e-6}), p}};
    const auto analysis = solve_static(mesh, model);
    const auto stress = nodal_stress(mesh, model.materials, analysis.solution.displacement);
    const double k = p * a * a / (b * b - a * a);
    double worst_u = 0, worst_s = 0;
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      const Vector3& x = mesh.nodes[n];
      const double r = std::hypot(x.x, x.y);
      const double* u = &analysis.solution.displacement[3 * n];
      const double radial = (u[0] * x.x + u[1] * x.y) / r;
      const double exact = (1 + nu) / e * k * ((1 - 2 * nu) * r + b * b / r);
      worst_u = std::max(worst_u, std::abs(radial / exact - 1));
      const double hoop =
          (stress[n][0] * x.y * x.y + stress[n][1] * x.x * x.x - 2 * stress[n][5] * x.x * x.y) /
          (r * r);
      worst_s = std::max(worst_s, std::abs(hoop - k * (1 + b * b / (r * r))) / (k * 5));
    }
    CHECK(worst_u < (fine == 1 ? 3e-4 : 3e-5));
    CHECK(worst_s < (fine == 1 ? .03 : .008));
    errors.push_back(worst_u);
  }
  CHECK(errors[0] / errors[1] > 6); // between h^3 and h^4
}

TEST_CASE("supports carry the loads, springs too") {
  Mesh mesh = tetrahedral_box({4, 3, 3}, {.1, .06, .05}, true);
  distort(mesh, .002);
  StaticModel model;
  model.materials = {steel()};
  model.fixed = {{"wall", select_nodes(mesh, plane(0, 0)), {true, true, false}, {}}};
  model.springs = {{"bed", select_faces(mesh, plane(2, 0)), {1e6, 2e6, 3e7}}};
  model.loads = {Gravity{{1, -2, -9.81}}, Pressure{"top", select_faces(mesh, plane(2, .05)), 2e5},
                 Traction{"side", select_faces(mesh, plane(1, .06)), {1e4, 2e4, 3e4}},
                 TotalForce{"end", select_faces(mesh, plane(0, .1)), {10, 20, 30}},
                 PointForce{5, {1, 2, 3}}};
  const auto analysis = solve_static(mesh, model);
  // rho V g - p A z + t A + F + P
  const double mass = 7850 * .1 * .06 * .05, top = .1 * .06, side = .1 * .05;
  const Vector3 expected = mass * Vector3{1, -2, -9.81} + Vector3{0, 0, -2e5 * top} +
                           side * Vector3{1e4, 2e4, 3e4} + Vector3{10, 20, 30} + Vector3{1, 2, 3};
  const Vector3 load = sum_of_forces(analysis.system.load);
  const Vector3 support = support_force(mesh, model, analysis.solution);
  CHECK(length(load - expected) < 1e-9 * length(expected));
  CHECK(length(load + support) < 1e-9 * length(load));
  CHECK(length(sum_of_forces(analysis.solution.reaction)) > 0);
}

TEST_CASE("pressure on a closed surface pushes nowhere and turns nothing") {
  for (const bool curved : {false, true}) {
    Mesh mesh =
        curved ? make_shape("sphere", {{"diameter", .1}}, {}, {.03}) : tetrahedral_block(2, true);
    const std::vector<Material> materials{steel()};
    const std::vector<Load> loads{Pressure{"sea", outer_faces(mesh), 1e5}};
    const auto f = load_vector(mesh, materials, loads);
    Vector3 sum, moment;
    double size = 0;
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      const Vector3 own{f[3 * n], f[3 * n + 1], f[3 * n + 2]};
      sum += own;
      moment += cross(mesh.nodes[n], own);
      size += length(own);
    }
    CHECK(size > 1);
    CHECK(length(sum) < 1e-12 * size);
    CHECK(length(moment) < 1e-10 * size);
  }
}

TEST_CASE("a sphere's curved faces have its area") {
  const Mesh mesh = make_shape("sphere", {{"diameter", .1}}, {}, {.02});
  check_close(area(mesh, outer_faces(mesh)), std::numbers::pi * .01, 1e-4);
}

TEST_CASE("a bedding of springs does not depend on how its faces are meshed") {
  // A column of E, nu = 0 on springs: every point of the base sinks by F / k, the top by F L / E A
  // more. A load off the middle tilts it by moment / (k w^2 / 12).
  for (const std::vector<double>& xs : {even(0, .02, 2), {0, .001, .003, .02}})
    for (const bool tets : {false, true}) {
      Mesh mesh = tets ? tetrahedral_box({int(xs.size()) - 1, 3, 2}, {.02, .02, .05}, true)
                       : block(xs, {{0, .013, .018, .02}}, even(0, .05, 2));
      StaticModel model;
      model.materials = {steel(0)};
      model.springs = {{"bed", select_faces(mesh, plane(2, 0)), {1e5, 1e5, 1e6}}};
      model.loads = {TotalForce{"press", select_faces(mesh, plane(2, .05)), {3, 0, -100}}};
      const auto analysis = solve_static(mesh, model);
      const auto& u = analysis.solution.displacement;
      for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
        if (mesh.nodes[n].z < 1e-9) { // moment of 3 N at 50 mm about the bed
          // The column bends by 1e-4 of the tilt.
          const double tilt = 3 * .05 / (1e6 * .0004 / 12);
          const double sinks = -100 / 1e6 - tilt * (mesh.nodes[n].x - .01);
          CHECK(u[3 * n + 2] == doctest::Approx(sinks).epsilon(2e-3));
          CHECK(u[3 * n] == doctest::Approx(3 / 1e5).epsilon(2e-3));
        }
    }
}

TEST_CASE("a column stands under its own weight") {
  const Mesh mesh = block(even(0, .1, 2), even(0, .1, 2), even(0, 2, 8));
  StaticModel model;
  model.materials = {steel(0)};
  model.fixed = {{"foot", select_nodes(mesh, plane(2, 0)), {true, true, true}, {}}};
  model.loads = {Gravity{{0, 0, -9.81}}};
  const auto analysis = solve_static(mesh, model);
  const auto& u = analysis.solution.displacement;
  const auto nodal = nodal_stress(mesh, model.materials, u);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const double z = mesh.nodes[n].z, load = 7850 * 9.81;
    CHECK(std::abs(u[3 * n + 2] + load * (2 * z - z * z / 2) / 2.1e11) < 1e-9 * load * 2 / 2.1e11);
    CHECK(std::abs(nodal[n][2] + load * (2 - z)) < 1e-6 * load);
  }
  CHECK(sum_of_forces(analysis.solution.reaction).z ==
        doctest::Approx(7850 * 9.81 * .02).epsilon(1e-9));
}

TEST_CASE("an orthotropic bar stretches by the modulus along it") {
  Material wood = spruce();
  wood.axis_1 = {1, 0, 0};
  wood.axis_2 = {0, 1, 0};
  for (int axis = 0; axis < 3; ++axis) {
    const Mesh mesh = block(even(0, .1, 2), even(0, .1, 2), even(0, .1, 2));
    StaticModel model;
    model.materials = {wood};
    for (int k = 0; k < 3; ++k)
      model.fixed.push_back(
          {"plane", select_nodes(mesh, plane(k, 0)), {k == 0, k == 1, k == 2}, {}});
    Vector3 pull;
    pull[axis] = 1e5;
    model.loads = {Traction{"pull", select_faces(mesh, plane(axis, .1)), pull}};
    const auto analysis = solve_static(mesh, model);
    for (const int n : nodes_on(mesh, axis, .1))
      CHECK(analysis.solution.displacement[3 * std::size_t(n) + std::size_t(axis)] ==
            doctest::Approx(1e5 / wood.young_pa[std::size_t(axis)] * .1).epsilon(1e-9));
  }
}

TEST_CASE("a bolt presses its hole with a cosine and exactly its force") {
  // p = 2 F / (pi r t) cos over the half that faces the force (the integral of cos^2 is pi / 2).
  const double r = .01, t = .005;
  Mesh ring = make_shape(
      "ring", {{"outer_diameter", .06}, {"inner_diameter", 2 * r}, {"thickness", t}}, {}, {.003});
  const auto wall = select_faces(ring, {OnCylinder{{0, 0, -1}, {0, 0, 1}, r, false}, 1e-6});
  const std::vector<Material> materials{steel()};
  for (const Vector3 force : {Vector3{1000, 0, 0}, {-300, 400, 0}, {1, 17, 0}}) {
    const std::vector<Load> loads{BoltLoad{"pin", wall, {0, 0, 2}, force}};
    const auto f = load_vector(ring, materials, loads);
    CHECK(length(sum_of_forces(f) - force) < 1e-10 * length(force));
    // Nodes behind the pin are free; the even pressure of a strip along the force is the peak.
    double behind = 0;
    Vector3 moment;
    for (std::size_t n = 0; n < ring.nodes.size(); ++n) {
      const Vector3 own{f[3 * n], f[3 * n + 1], f[3 * n + 2]};
      if (dot(ring.nodes[n], force) < -.3 * r * length(force))
        behind = std::max(behind, length(own));
      moment += cross({ring.nodes[n].x, ring.nodes[n].y, 0}, own);
    }
    CHECK(behind == 0);
    CHECK(std::abs(moment.z) < 1e-6 * r * length(force)); // normal pressure turns nothing
  }
  // The pressure's second moment: integral of p (n . d)^2 over the wall, from the loads on a body.
  const std::vector<Load> along{BoltLoad{"pin", wall, {0, 0, 1}, {0, 0, 1}}};
  CHECK(mentions(refusal([&] { (void)load_vector(ring, materials, along); }), "bolt pin"));
  CHECK(mentions(refusal([&] { (void)load_vector(ring, materials, along); }),
                 "along the hole's axis"));
  double low = 0;
  for (const Vector3& p : ring.nodes)
    low = std::min(low, p.z);
  const auto flat = select_faces(ring, plane(2, low));
  const std::vector<Load> nowhere{BoltLoad{"pin", flat, {0, 0, 1}, {1, 0, 0}}};
  CHECK(mentions(refusal([&] { (void)load_vector(ring, materials, nowhere); }),
                 "wall of a round hole"));
}

TEST_CASE("stress measures have their textbook values and slopes") {
  const Stress pull{1e6, 0, 0, 0, 0, 0}, shear{0, 0, 0, 0, 0, 1e6}, sea{-1e6, -1e6, -1e6, 0, 0, 0};
  CHECK(von_mises(pull) == doctest::Approx(1e6));
  CHECK(max_shear(pull) == doctest::Approx(.5e6));
  CHECK(von_mises(shear) == doctest::Approx(std::sqrt(3) * 1e6));
  CHECK(max_shear(shear) == doctest::Approx(1e6));
  CHECK(von_mises(sea) == doctest::Approx(0));
  CHECK(principal(shear)[0] == doctest::Approx(1e6));
  CHECK(principal(shear)[2] == doctest::Approx(-1e6));
  const Stress s{3e6, -1e6, 2e6, .5e6, -.7e6, 1.2e6};
  const auto p = principal(s);
  CHECK(p[0] > p[1]);
  CHECK(p[1] > p[2]);
  CHECK(p[0] + p[1] + p[2] == doctest::Approx(4e6)); // the trace
  CHECK(von_mises(s) ==
        doctest::Approx(std::sqrt(((p[0] - p[1]) * (p[0] - p[1]) + (p[1] - p[2]) * (p[1] - p[2]) +
                                   (p[2] - p[0]) * (p[2] - p[0])) /
                                  2)));
  for (std::size_t v = 0; v < 6; ++v) {
    Stress up = s, down = s;
    up[v] += 1;
    down[v] -= 1;
    CHECK(von_mises_slope(s)[v] ==
          doctest::Approx((von_mises(up) - von_mises(down)) / 2).epsilon(1e-6));
    CHECK(max_shear_slope(s)[v] ==
          doctest::Approx((max_shear(up) - max_shear(down)) / 2).epsilon(1e-6));
  }
  CHECK(von_mises_slope({}) == Stress{});
}

TEST_CASE("peak and smoothed stress are what their definitions say") {
  // Linear tetrahedra of uneven volume: each has one stress, so a node's is the plain weighted sum.
  Mesh mesh = tetrahedral_block(3, false);
  distort(mesh, .1);
  StaticModel model;
  model.materials = {steel()};
  model.fixed = {{"wall", nodes_on(mesh, 0, 0), {true, true, true}, {}}};
  model.loads = {TotalForce{"tip", select_faces(mesh, plane(0, 1)), {1e6, 2e6, -3e6}}};
  const auto analysis = solve_static(mesh, model);
  const auto& u = analysis.solution.displacement;
  const auto stress = element_stress(mesh, model.materials, u);
  const auto nodal = nodal_stress(mesh, model.materials, u);
  std::vector<Stress> sum(mesh.nodes.size(), Stress{});
  std::vector<double> whole(mesh.nodes.size(), 0.0);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const auto nodes = mesh.nodes_of(mesh.elements[e]);
    const auto at = [&](std::size_t a) { return mesh.nodes[std::size_t(nodes[a])]; };
    const double v = dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))) / 6;
    CHECK(element_volumes(mesh)[e] == doctest::Approx(v).epsilon(1e-12));
    for (const int n : nodes) {
      whole[std::size_t(n)] += v;
      for (std::size_t k = 0; k < 6; ++k)
        sum[std::size_t(n)][k] += v * stress[e][k];
    }
  }
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    for (std::size_t k = 0; k < 6; ++k)
      CHECK(std::abs(nodal[n][k] - sum[n][k] / whole[n]) < 1e-9 * 1e7);
  // Bricks in bending: the peak is the largest of the quadrature points, by definition.
  const Cantilever beam(block(even(0, .2, 6), even(0, .02, 1), even(0, .02, 1)), .3);
  const auto bent = solve_static(beam.mesh, beam.model).solution.displacement;
  const PeakStress peak = peak_stress(beam.mesh, beam.model.materials, bent);
  const auto laws = elastic_laws(beam.mesh, beam.model.materials);
  for (std::size_t e = 0; e < beam.mesh.elements.size(); ++e) {
    double mises = 0, shear = 0;
    for (const double x : {-.7745966692414834, 0., .7745966692414834})
      for (const double y : {-.7745966692414834, 0., .7745966692414834})
        for (const double z : {-.7745966692414834, 0., .7745966692414834}) {
          const Stress s = stress_at(beam.mesh, beam.mesh.elements[e], laws[0], bent, {x, y, z});
          mises = std::max(mises, von_mises(s));
          shear = std::max(shear, max_shear(s));
        }
    CHECK(peak.von_mises[e] == doctest::Approx(mises).epsilon(1e-9));
    CHECK(peak.max_shear[e] == doctest::Approx(shear).epsilon(1e-9));
  }
}

TEST_CASE("bodies that can move are refused with the motion that is free") {
  Mesh mesh = block(even(0, .1, 2), even(0, .02, 1), even(0, .02, 1));
  StaticModel model;
  model.materials = {steel()};
  const auto error_text = [&] { return refusal([&] { (void)solve_static(mesh, model); }); };
  CHECK(mentions(error_text(), "the body is not held: 6 of its 6 rigid motions are free"));
  model.fixed = {{"edge", nodes_on(mesh, 0, 0), {true, false, true}, {}}};
  CHECK(mentions(error_text(),
                 "1 of its 6 rigid motions are free, among them a translation along y"));
  // A hinge: one edge held.
  std::vector<int> hinge;
  for (const int n : nodes_on(mesh, 0, 0))
    if (mesh.nodes[std::size_t(n)].z == 0)
      hinge.push_back(n);
  model.fixed = {{"hinge", hinge, {true, true, true}, {}}};
  CHECK(mentions(error_text(),
                 "1 of its 6 rigid motions are free, among them a rotation about y through (0, "
                 "10, 0) mm"));
  model.springs = {{"rest", select_faces(mesh, plane(0, .1)), {0, 0, 1}}};
  CHECK(error_text().empty());
  model.springs = {{"rest", select_faces(mesh, plane(0, .1)), {0, 1, 0}}};
  CHECK(mentions(error_text(), "a rotation about y"));
  model.springs.clear();
  // A slanted slide: free along one direction that is no axis.
  Mesh turned = mesh;
  for (Vector3& p : turned.nodes)
    p = {.8 * p.x - .6 * p.y, .6 * p.x + .8 * p.y, p.z};
  std::vector<int> edge;
  for (std::size_t n = 0; n < turned.nodes.size(); ++n)
    if (mesh.nodes[n].y == 0 && mesh.nodes[n].z == 0)
      edge.push_back(static_cast<int>(n));
  model.fixed = {{"edge", edge, {true, true, true}, {}}};
  CHECK(mentions(refusal([&] { (void)solve_static(turned, model); }),
                 "a rotation about (0.8, 0.6, 0) through"));
  // Two pieces, one held.
  Mesh two = mesh;
  const int shift = static_cast<int>(mesh.nodes.size());
  for (const Vector3& p : mesh.nodes)
    two.nodes.push_back(p + Vector3{0, 0, .1});
  for (const Element& e : mesh.elements) {
    std::vector<int> nodes(mesh.nodes_of(e).begin(), mesh.nodes_of(e).end());
    for (int& n : nodes)
      n += shift;
    two.add(e.shape, nodes);
  }
  model.fixed = {{"wall", nodes_on(mesh, 0, 0), {true, true, true}, {}}};
  CHECK(mentions(refusal([&] { (void)solve_static(two, model); }), "piece 2 of 2 (body, around"));
}

TEST_CASE("a bad model is one sentence that names its part") {
  const Mesh mesh = block(even(0, .1, 2), even(0, .02, 1), even(0, .02, 1));
  const auto error_text = [&](const std::function<void(StaticModel&)>& spoil) {
    StaticModel model;
    model.materials = {steel()};
    model.fixed = {{"wall", nodes_on(mesh, 0, 0), {true, true, true}, {}}};
    spoil(model);
    return refusal([&] { (void)solve_static(mesh, model); });
  };
  const auto top = select_faces(mesh, plane(2, .02));
  CHECK(error_text([](auto&) {}).empty());
  CHECK(mentions(error_text([](auto& m) { m.materials.clear(); }), "expected one for each"));
  CHECK(mentions(error_text([](auto& m) { m.fixed[0].nodes = {99999}; }),
                 "support wall holds node 100000"));
  CHECK(mentions(error_text([](auto& m) { m.fixed[0].nodes.clear(); }),
                 "support wall holds no node"));
  CHECK(mentions(error_text([](auto& m) { m.fixed[0].directions = {}; }), "holds no direction"));
  CHECK(mentions(error_text([](auto& m) { m.fixed[0].displacement_m.x = NAN; }), "no number"));
  CHECK(mentions(error_text([](auto& m) {
                   m.fixed.push_back(m.fixed[0]);
                   m.fixed[1].displacement_m.z = 1e-3;
                 }),
                 "another place"));
  CHECK(mentions(error_text([](auto& m) {
                   m.loads = {Pressure{"lid", {}, 1}};
                 }),
                 "pressure lid has no face"));
  CHECK(mentions(error_text([](auto& m) {
                   m.loads = {Pressure{"lid", {{7, 0}}, 1}};
                 }),
                 "element 8"));
  CHECK(mentions(error_text([](auto& m) { m.loads = {Pressure{"lid", {{0, 6}}, 1}}; }), "face 6"));
  CHECK(mentions(error_text([&](auto& m) {
                   m.loads = {Pressure{"lid", top, NAN}};
                 }),
                 "pressure lid"));
  CHECK(mentions(error_text([&](auto& m) {
                   m.loads = {Traction{"t", top, {0, INFINITY, 0}}};
                 }),
                 "traction t"));
  CHECK(mentions(error_text([&](auto& m) {
                   m.loads = {TotalForce{"t", top, {NAN, 0, 0}}};
                 }),
                 "force t"));
  CHECK(mentions(error_text([](auto& m) { m.loads = {PointForce{-1, {}}}; }), "node 0"));
  CHECK(mentions(error_text([](auto& m) { m.loads = {Gravity{{NAN, 0, 0}}}; }), "gravity"));
  CHECK(mentions(error_text([&](auto& m) {
                   m.springs = {{"bed", top, {0, -1, 0}}};
                 }),
                 "spring bed"));
  CHECK(mentions(error_text([&](auto& m) {
                   m.springs = {{"bed", {}, {0, 1, 0}}};
                 }),
                 "spring bed has no face"));
}

TEST_CASE("places are chosen by box, plane, sphere, cylinder and name") {
  Mesh mesh = block(even(0, 1, 4), even(0, 1, 4), even(0, 1, 4));
  mesh.node_sets["lid"] = nodes_on(mesh, 2, 1);
  const auto nodes = [&](const auto& region) { return select_nodes(mesh, {region, 0}).size(); };
  const auto faces = [&](const auto& region) { return select_faces(mesh, {region, 0}).size(); };
  CHECK(nodes(OnPlane{{0, 0, 1}, {0, 0, 3}}) == 65); // 81 of a lattice without 16 face middles
  CHECK(faces(OnPlane{{0, 0, 1}, {0, 0, 3}}) == 16);
  CHECK(mentions(refusal([&] {
                   (void)faces(OnPlane{{0, 0, .5}, {0, 0, 1}});
                 }),
                 "no face of the skin"));
  CHECK(faces(InNodeSet{"lid"}) == 16);
  CHECK(nodes_of_faces(mesh, select_faces(mesh, {InNodeSet{"lid"}, 0})) == nodes_on(mesh, 2, 1));
  CHECK(faces(InBox{{{0, 0, 0}, {1, 1, .5}}}) == 48); // the floor and half of four walls
  CHECK(nodes(InBox{{{0, 0, 0}, {.1, .1, .1}}}) == 1);
  CHECK(nodes(OnSphere{{0, 0, 0}, .25, false}) == 3);
  CHECK(nodes(OnSphere{{0, 0, 0}, .25, true}) == 7);
  CHECK(nodes(OnCylinder{{0, 0, 0}, {0, 0, .5}, .25, false}) == 10);
  CHECK(nodes(OnCylinder{{0, 0, 0}, {0, 0, .5}, .25, true}) == 21);
  CHECK(mentions(refusal([&] { (void)nodes(InNodeSet{"floor"}); }), "expected one of: lid"));
  CHECK(mentions(refusal([&] { (void)nodes(OnPlane{}); }), "no normal"));
  CHECK(mentions(refusal([&] { (void)nodes(OnSphere{}); }), "radius"));
  CHECK(mentions(refusal([&] { (void)nodes(OnCylinder{{}, {}, 1}); }), "no length"));
  CHECK(mentions(refusal([&] { (void)nodes(InBox{{{1, 0, 0}, {0, 1, 1}}}); }), "along x"));
  CHECK(mentions(refusal([&] { (void)nodes(OnSphere{{9, 9, 9}, 1}); }), "no node"));
}

#include "fem/error/singular.hpp"
#include "fem/shapes/shapes.hpp"
#include "fem/statics/recovery.hpp"
#include "static_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

using namespace tactus::fem;
using tactus::Vec3;

namespace {

/// u = H x everywhere on the skin: the linear field that every element must hold inside.
constexpr std::array<Vec3, 3> kGradient{
    {{1e-3, 2e-4, -3e-4}, {4e-4, -5e-4, 6e-4}, {-2e-4, 1e-4, 8e-4}}};
Vec3 linear_field(const Vec3& p) {
  return {dot(kGradient[0], p), dot(kGradient[1], p), dot(kGradient[2], p)};
}

/// Moves inner nodes; straight sides stay straight.
void distort(Mesh& mesh, double by) {
  const std::vector<Vec3> old = mesh.nodes;
  const std::vector<int> skin = outer_nodes(mesh);
  const auto moved = [&](int n) {
    const Vec3& p = old[static_cast<std::size_t>(n)];
    const double phase = 7 * n;
    return std::find(skin.begin(), skin.end(), n) != skin.end()
               ? p
               : p + by * Vec3{std::sin(phase), std::sin(2 * phase), std::sin(3 * phase)};
  };
  for (const Element& e : mesh.elements) {
    const auto reference = reference_nodes(e.shape);
    const auto nodes = mesh.nodes_of(e);
    const auto corners = static_cast<std::size_t>(corner_count(e.shape));
    for (std::size_t m = 0; m < nodes.size(); ++m)
      for (std::size_t a = 0; a < corners; ++a)
        for (std::size_t b = 0; b <= a; ++b) // a corner, or the middle of two
          if (length(.5 * (reference[a] + reference[b]) - reference[m]) < 1e-9)
            mesh.nodes[static_cast<std::size_t>(nodes[m])] =
                .5 * (moved(nodes[a]) + moved(nodes[b]));
  }
}

/// The unit cube: columns of bricks and of pairs of wedges by turns, a brick in the middle of its
/// column as six pyramids.
Mesh mixed_linear_block() {
  Mesh mesh;
  for (int n = 0; n < 64; ++n)
    mesh.nodes.push_back((1. / 3) * Vec3{double(n % 4), double(n / 4 % 4), double(n / 16)});
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        const int a = i + 4 * j + 16 * k;
        const std::array cell{a, a + 1, a + 5, a + 4, a + 16, a + 17, a + 21, a + 20};
        if ((i + j) % 2) {
          for (const auto& [p, q] : {std::array<std::size_t, 2>{1, 2}, {2, 3}})
            mesh.add(Shape::wedge6,
                     std::array{cell[0], cell[p], cell[q], cell[4], cell[p + 4], cell[q + 4]});
        } else if (k != 1) {
          mesh.add(Shape::hex8, cell);
        } else {
          const int apex = static_cast<int>(mesh.nodes.size());
          mesh.nodes.push_back(mesh.nodes[static_cast<std::size_t>(a)] + Vec3{.15, .17, .18});
          for (const Face& f : faces(Shape::hex8)) {
            const auto at = [&](std::size_t c) {
              return cell[static_cast<std::size_t>(f.node[c])];
            };
            mesh.add(Shape::pyramid5, std::array{at(3), at(2), at(1), at(0), apex});
          }
        }
      }
  return mesh;
}

void check_constant_strain(const Mesh& mesh, const Material& material) {
  check(mesh);
  StaticModel model;
  model.materials = {material};
  for (const int n : outer_nodes(mesh))
    model.fixed.push_back(
        {"skin", {n}, {true, true, true}, linear_field(mesh.nodes[static_cast<std::size_t>(n)])});
  const StaticAnalysis analysis = solve_static(mesh, model);
  const auto& u = analysis.solution.displacement;
  double worst = 0, size = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const Vec3 exact = linear_field(mesh.nodes[n]);
    worst = std::max(worst, length(of_node(u, n) - exact));
    size = std::max(size, length(exact));
  }
  CHECK(worst < 1e-10 * size);
  const ElasticMatrix c = elastic_matrix(material);
  const auto& [x, y, z] = kGradient;
  const std::array strain{x.x, y.y, z.z, y.z + z.y, x.z + z.x, x.y + y.x};
  Stress exact{};
  for (std::size_t v = 0; v < 6; ++v)
    for (std::size_t w = 0; w < 6; ++w)
      exact[v] += c[v][w] * strain[w];
  for (const auto& list : {element_stress(mesh, model.materials, u),
                           recovered_stress(mesh, model.materials, u).at_nodes})
    for (const Stress& s : list)
      for (std::size_t v = 0; v < 6; ++v)
        REQUIRE(std::abs(s[v] - exact[v]) < 1e-10 * von_mises(exact));
}

} // namespace

TEST_CASE("constant strain is exact on distorted elements of every shape") {
  Mesh tets = tetrahedral_block(3, true), linear = tetrahedral_block(3, false);
  distort(tets, .07);
  distort(linear, .07);
  Mesh bricks = block(even(0, 1, 3), even(0, 1, 3), even(0, 1, 3));
  distort(bricks, .07);
  Mesh mixed = mixed_linear_block();
  distort(mixed, .04);
  for (const Material& m : {steel(), oblique_spruce()}) {
    check_constant_strain(tets, m);
    check_constant_strain(linear, m);
    check_constant_strain(bricks, m);
    check_constant_strain(mixed, m);
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
  CHECK(beam.tip(beam.solve().solution.displacement) / theory - 1 ==
        doctest::Approx(9.65e-6).epsilon(.15));
}

TEST_CASE("a clamped steel cantilever is a little stiffer than Timoshenko's beam") {
  const Cantilever beam(Cantilever::tetrahedra(), .3);
  const double e = 2.1e11, inertia = std::pow(.02, 4) / 12, shear = e / 2.6, nu = .3;
  const double kappa = 10 * (1 + nu) / (12 + 11 * nu); // Cowper 1966
  const double theory = 100 * .008 / (3 * e * inertia) + 100 * .2 / (kappa * .0004 * shear);
  const auto analysis = beam.solve();
  const auto& u = analysis.solution.displacement;
  check_close(beam.tip(u), theory, .01);
  check_close(beam.tip(u), 9.5265e-5, 1e-3); // another program's tet10, 49 600 unknowns
  // Clapeyron: the strain energy is half the work of the loads.
  const double work = std::inner_product(u.begin(), u.end(), analysis.system.load.begin(), 0.);
  check_close(analysis.solution.strain_energy, work / 2, 1e-10);
  // Bending stress M z / I in the outer fibres, away from both ends.
  const auto stress = element_stress(beam.mesh, beam.model.materials, u);
  int compared = 0;
  for (std::size_t k = 0; k < stress.size(); ++k) {
    Vec3 middle;
    for (const int n : beam.mesh.nodes_of(beam.mesh.elements[k]).first(4))
      middle += .25 * beam.mesh.nodes[std::size_t(n)];
    const double z = middle.z - .01;
    if (middle.x < .04 || middle.x > .16 || std::abs(z) < .006)
      continue;
    CHECK(von_mises(stress[k]) ==
          doctest::Approx(100 * (.2 - middle.x) * std::abs(z) / inertia).epsilon(.031));
    ++compared;
  }
  CHECK(compared > 300);
}

TEST_CASE("a round hole in a wide plate raises the stress three times") {
  // Kirsch 1898, in plane strain (a free plate's stress varies through its thickness, by 5 % in one
  // as thick as this). The plate is 60 diameters wide: Howland's correction is below 0.1 %.
  const double a = .01, b = 60 * a, thickness = .004;
  Mesh mesh = quarter_plate(a, b, thickness, true, 22, 12, 1.35);
  StaticModel model;
  model.materials = {steel()};
  model.fixed = symmetry(mesh, {{0, 0}, {1, 0}, {2, 0}, {2, thickness}});
  model.loads = {Traction{"pull", select_faces(mesh, plane(0, b)), {1e6, 0, 0}}};
  const auto analysis = solve_static(mesh, model);
  const auto stress =
      recovered_stress(mesh, model.materials, analysis.solution.displacement).at_nodes;
  int found = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const Vec3 x{mesh.nodes[n].x, mesh.nodes[n].y, 0};
    if (length(x - Vec3{0, a, 0}) < 1e-9) {
      CHECK(stress[n][0] / 1e6 == doctest::Approx(3.00).epsilon(.01));
      ++found;
    } else if (length(x - Vec3{a, 0, 0}) < 1e-9) {
      CHECK(stress[n][1] / 1e6 == doctest::Approx(-1.00).epsilon(.02));
      ++found;
    } else if (x.x == 0 && x.y < 3 * a) {
      const double q = a * a / (x.y * x.y); // away from the edge
      check_close(stress[n][0], 1e6 * (2 + q + 3 * q * q) / 2, .02);
    }
  }
  CHECK(found == 6);
}

TEST_CASE("a thick tube under pressure yields as Lame's") {
  const double a = .05, b = .1, p = 1e7, nu = .3, e = 2.1e11;
  std::vector<double> errors;
  for (const int fine : {1, 2}) {
    Mesh mesh = quarter_plate(a, b, .01, false, 4 * fine, 6 * fine, 1.01);
    StaticModel model;
    model.materials = {steel(nu)};
    model.fixed = symmetry(mesh, {{0, 0}, {1, 0}, {2, 0}, {2, .01}});
    model.loads = {Pressure{
        "bore", select_faces(mesh, {OnCylinder{{0, 0, -1}, {0, 0, 1}, a, false}, 1e-6}), p}};
    const auto analysis = solve_static(mesh, model);
    const auto stress =
        recovered_stress(mesh, model.materials, analysis.solution.displacement).at_nodes;
    const double k = p * a * a / (b * b - a * a);
    double worst_u = 0, worst_s = 0;
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      const Vec3& x = mesh.nodes[n];
      const double r = std::hypot(x.x, x.y);
      const Vec3 u = of_node(analysis.solution.displacement, n);
      const double radial = (u.x * x.x + u.y * x.y) / r;
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

TEST_CASE("recovered stress at Lame's bore tells what it misses") {
  const double a = .05, b = .1, p = 1e7, hoop = p * (a * a + b * b) / (b * b - a * a);
  double last = 1e9;
  for (const int fine : {1, 2}) {
    Mesh mesh = quarter_plate(a, b, .01, false, 4 * fine, 6 * fine, 1.01);
    StaticModel model;
    model.materials = {steel()};
    model.fixed = symmetry(mesh, {{0, 0}, {1, 0}, {2, 0}});
    model.loads = {Pressure{
        "bore", select_faces(mesh, {OnCylinder{{0, 0, -1}, {0, 0, 1}, a, false}, 1e-6}), p}};
    const auto u = solve_static(mesh, model).solution.displacement;
    const RecoveredStress recovered = recovered_stress(mesh, model.materials, u);
    const double exact = von_mises({-p, hoop, 0, 0, 0, 0});
    double worst = 0, min_estimate = exact, largest_estimate = 0;
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      if (std::abs(std::hypot(mesh.nodes[n].x, mesh.nodes[n].y) - a) < 1e-9) {
        worst = std::max(worst, std::abs(von_mises(recovered.at_nodes[n]) - exact));
        min_estimate = std::min(min_estimate, recovered.error[n]);
        largest_estimate = std::max(largest_estimate, recovered.error[n]);
      }
    CAPTURE(worst / exact);
    CAPTURE(min_estimate / exact);
    CAPTURE(largest_estimate / exact);
    CHECK(worst < min_estimate);
    CHECK(worst < (fine == 1 ? .02 : .003) * exact);
    CHECK(largest_estimate < 8 * worst);
    CHECK(worst < .5 * last);
    last = worst;
  }
}

TEST_CASE("a support that is a plane of symmetry is no singular corner, a clamp is") {
  const Mesh mesh = block(even(0, .1, 4), even(0, .03, 3), even(0, .03, 3));
  const auto singular = [&](std::array<bool, 3> directions) {
    const std::vector<FixedPatch> patch{{"end", select_nodes(mesh, plane(0, 0)), directions, {}}};
    const auto nodes = singular_nodes(mesh, held_directions(mesh, patch), kSharpTurn);
    return std::count(nodes.begin(), nodes.end(), 1);
  };
  CHECK(singular({true, false, false}) == 0);
  CHECK(singular({true, true, true}) == 24); // corners and middle nodes of the end's border
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
  const Vec3 expected = mass * Vec3{1, -2, -9.81} + Vec3{0, 0, -2e5 * top} +
                        side * Vec3{1e4, 2e4, 3e4} + Vec3{10, 20, 30} + Vec3{1, 2, 3};
  const Vec3 load = sum_of_forces(analysis.system.load);
  const Vec3 support = support_force(mesh, model, analysis.solution);
  CHECK(length(load - expected) < 1e-9 * length(expected));
  CHECK(length(load + support) < 1e-9 * length(load));
  CHECK(length(sum_of_forces(analysis.solution.reaction)) > 0);
}

TEST_CASE("pressure on a closed surface pushes nowhere and turns nothing; a sphere has its area") {
  for (const bool curved : {false, true}) {
    Mesh mesh =
        curved ? make_shape("sphere", {{"diameter", .1}}, {}, {.02}) : tetrahedral_block(2, true);
    const std::vector<Material> materials{steel()};
    const std::vector<Load> loads{Pressure{"sea", outer_faces(mesh), 1e5}};
    const auto f = load_vector(mesh, materials, loads);
    Vec3 sum, moment;
    double size = 0;
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      const Vec3 own = of_node(f, n);
      sum += own;
      moment += cross(mesh.nodes[n], own);
      size += length(own);
    }
    CHECK(size > 1);
    CHECK(length(sum) < 1e-12 * size);
    CHECK(length(moment) < 1e-10 * size);
    check_close(area(mesh, outer_faces(mesh)), curved ? std::numbers::pi * .01 : 6, 1e-4);
  }
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
  const auto nodal = recovered_stress(mesh, model.materials, u).at_nodes;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const double z = mesh.nodes[n].z, load = 7850 * 9.81;
    CHECK(std::abs(u[3 * n + 2] + load * (2 * z - z * z / 2) / 2.1e11) < 1e-9 * load * 2 / 2.1e11);
    CHECK(std::abs(nodal[n][2] + load * (2 - z)) < 1e-6 * load);
  }
  CHECK(sum_of_forces(analysis.solution.reaction).z ==
        doctest::Approx(7850 * 9.81 * .02).epsilon(1e-9));
}

TEST_CASE("an orthotropic bar stretches by the modulus along it") {
  Material wood = oblique_spruce();
  wood.axis_1 = {1, 0, 0};
  wood.axis_2 = {0, 1, 0};
  for (int axis = 0; axis < 3; ++axis) {
    const Mesh mesh = block(even(0, .1, 2), even(0, .1, 2), even(0, .1, 2));
    StaticModel model;
    model.materials = {wood};
    model.fixed = symmetry(mesh, {{0, 0}, {1, 0}, {2, 0}});
    Vec3 pull;
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
  const Selection bore{OnCylinder{{0, 0, -1}, {0, 0, 1}, r, false}, 1e-6};
  const auto wall = select_faces(ring, bore);
  const std::vector<Material> materials{steel()};
  for (const Vec3 force : {Vec3{1000, 0, 0}, {-300, 400, 0}, {1, 17, 0}}) {
    const std::vector<Load> loads{BoltLoad{"pin", wall, {0, 0, 2}, force}};
    const auto f = load_vector(ring, materials, loads);
    CHECK(length(sum_of_forces(f) - force) < 1e-10 * length(force));
    // Nodes behind the pin are free; the even pressure of a strip along the force is the peak.
    double behind = 0;
    Vec3 moment;
    for (std::size_t n = 0; n < ring.nodes.size(); ++n) {
      const Vec3 own = of_node(f, n);
      if (dot(ring.nodes[n], force) < -.3 * r * length(force))
        behind = std::max(behind, length(own));
      moment += cross({ring.nodes[n].x, ring.nodes[n].y, 0}, own);
    }
    CHECK(behind == 0);
    CHECK(std::abs(moment.z) < 1e-6 * r * length(force)); // normal pressure turns nothing
  }
  const auto refused = [&](const Selection& faces, const Vec3& force, const char* words) {
    const std::vector<Load> loads{BoltLoad{"pin", select_faces(ring, faces), {0, 0, 1}, force}};
    check_refused([&] { return load_vector(ring, materials, loads); }, words);
  };
  refused(bore, {0, 0, 1}, "along the hole's axis");
  refused(plane(2, bounding_box(ring.nodes).low.z), {1, 0, 0}, "wall of a round hole");
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

TEST_CASE("bodies that can move are refused with the motion that is free") {
  const Mesh mesh = block(even(0, .1, 2), even(0, .02, 1), even(0, .02, 1));
  std::vector<int> hinge, slanted; // two edges of the body
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const Vec3& p = mesh.nodes[n];
    if (p.x == 0 && p.z == 0)
      hinge.push_back(static_cast<int>(n));
    if (p.y == 0 && p.z == 0)
      slanted.push_back(static_cast<int>(n));
  }
  const std::vector<int> wall = nodes_on(mesh, 0, 0);
  Mesh turned = mesh;
  for (Vec3& p : turned.nodes)
    p = {.8 * p.x - .6 * p.y, .6 * p.x + .8 * p.y, p.z};
  const auto rest = [&](const Vec3& stiffness) {
    return SpringPatch{"rest", select_faces(mesh, plane(0, .1)), stiffness};
  };
  const auto refused = [](const Mesh& body, std::vector<FixedPatch> fixed,
                          std::vector<SpringPatch> springs, const char* words) {
    StaticModel model;
    model.materials = {steel()};
    model.fixed = std::move(fixed);
    model.springs = std::move(springs);
    check_refused([&] { return solve_static(body, model); }, words);
  };
  refused(mesh, {}, {}, "the body is not fully supported: 6 of its 6 rigid motions are free");
  refused(mesh, {{"edge", wall, {true, false, true}, {}}}, {},
          "1 of its 6 rigid motions are free, among them a translation along y");
  refused(mesh, {{"hinge", hinge, {true, true, true}, {}}}, {},
          "1 of its 6 rigid motions are free, among them a rotation about y through (0, 10, 0) mm");
  refused(mesh, {{"hinge", hinge, {true, true, true}, {}}}, {rest({0, 1, 0})},
          "a rotation about y");
  refused(mesh, {{"hinge", hinge, {true, true, true}, {}}}, {rest({0, 0, 1})},
          "nothing was refused");
  refused(turned, {{"edge", slanted, {true, true, true}, {}}}, {},
          "a rotation about (0.8, 0.6, 0) through");
  refused(two_of(mesh, {0, 0, .1}), {{"wall", wall, {true, true, true}, {}}}, {},
          "piece 2 of 2 (body, around");
}

TEST_CASE("a bad model is one sentence that names its part") {
  const Mesh mesh = block(even(0, .1, 2), even(0, .02, 1), even(0, .02, 1));
  const auto top = select_faces(mesh, plane(2, .02));
  const auto refused = [&](const auto& spoil, const char* words) {
    StaticModel model;
    model.materials = {steel()};
    model.fixed = {{"wall", nodes_on(mesh, 0, 0), {true, true, true}, {}}};
    spoil(model);
    check_refused([&] { return solve_static(mesh, model); }, words);
  };
  refused([](auto&) {}, "nothing was refused");
  refused([](auto& m) { m.materials.clear(); }, "expected one for each");
  refused([](auto& m) { m.fixed[0].nodes = {99999}; }, "support wall fixes node 100000");
  refused([](auto& m) { m.fixed[0].nodes.clear(); }, "support wall selects no node");
  refused([](auto& m) { m.fixed[0].directions = {}; }, "fixes no direction");
  refused([](auto& m) { m.fixed[0].displacement_m.x = NAN; }, "not a finite number");
  refused(
      [](auto& m) {
        m.fixed.push_back(m.fixed[0]);
        m.fixed[1].displacement_m.z = 1e-3;
      },
      "another displacement");
  const auto load = [&](const Load& bad, const char* words) {
    refused([&](auto& m) { m.loads = {bad}; }, words);
  };
  load(Pressure{"lid", {}, 1}, "pressure lid has no face");
  load(Pressure{"lid", {{7, 0}}, 1}, "element 8");
  load(Pressure{"lid", {{0, 6}}, 1}, "face 6");
  load(Pressure{"lid", top, NAN}, "pressure lid");
  load(Traction{"t", top, {0, INFINITY, 0}}, "traction t");
  load(TotalForce{"t", top, {NAN, 0, 0}}, "force t");
  load(PointForce{-1, {}}, "node 0");
  load(Gravity{{NAN, 0, 0}}, "gravity");
  const auto spring = [&](const SpringPatch& bad, const char* words) {
    refused([&](auto& m) { m.springs = {bad}; }, words);
  };
  spring({"bed", top, {0, -1, 0}}, "spring bed");
  spring({"bed", {}, {0, 1, 0}}, "spring bed has no face");
}

TEST_CASE("places are chosen by box, plane, sphere, cylinder and name") {
  Mesh mesh = block(even(0, 1, 4), even(0, 1, 4), even(0, 1, 4));
  mesh.node_sets["lid"] = nodes_on(mesh, 2, 1);
  const auto nodes = [&](const auto& region) { return select_nodes(mesh, {region, 0}).size(); };
  const auto faces = [&](const auto& region) { return select_faces(mesh, {region, 0}).size(); };
  CHECK(nodes(OnPlane{{0, 0, 1}, {0, 0, 3}}) == 65); // 81 of a lattice without 16 face middles
  CHECK(faces(OnPlane{{0, 0, 1}, {0, 0, 3}}) == 16);
  CHECK(faces(InNodeSet{"lid"}) == 16);
  CHECK(nodes_of_faces(mesh, select_faces(mesh, {InNodeSet{"lid"}, 0})) == nodes_on(mesh, 2, 1));
  CHECK(faces(InBox{{{0, 0, 0}, {1, 1, .5}}}) == 48); // the floor and half of four walls
  CHECK(nodes(InBox{{{0, 0, 0}, {.1, .1, .1}}}) == 1);
  CHECK(nodes(OnSphere{{0, 0, 0}, .25, false}) == 3);
  CHECK(nodes(OnSphere{{0, 0, 0}, .25, true}) == 7);
  CHECK(nodes(OnCylinder{{0, 0, 0}, {0, 0, .5}, .25, false}) == 10);
  CHECK(nodes(OnCylinder{{0, 0, 0}, {0, 0, .5}, .25, true}) == 21);
  check_refused([&] { return faces(OnPlane{{0, 0, .5}, {0, 0, 1}}); }, "no face of the skin");
  check_refused([&] { return nodes(InNodeSet{"floor"}); }, "expected one of: lid");
  check_refused([&] { return nodes(OnPlane{}); }, "no normal");
  check_refused([&] { return nodes(OnSphere{}); }, "radius");
  check_refused([&] { return nodes(OnCylinder{{}, {}, 1}); }, "no length");
  check_refused([&] { return nodes(InBox{{{1, 0, 0}, {0, 1, 1}}}); }, "along x");
  check_refused([&] { return nodes(OnSphere{{9, 9, 9}, 1}); }, "no node");
}

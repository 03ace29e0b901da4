// Bodies whose frequencies are known in closed form, or agreed between programs.
#include "fem/modes/residual_compliance.hpp"
#include "static_bodies.hpp"

#include <algorithm>
#include <numbers>

using namespace tactus::fem;
using tactus::Vec3;
constexpr double kPi = std::numbers::pi;

namespace {
/// How often a frequency occurs within a tolerance.
int occurrences(const Modes& modes, double frequency, double tolerance) {
  int count = 0;
  for (const double f : modes.frequency_hz)
    count += std::abs(f / frequency - 1) < tolerance;
  return count;
}
} // namespace

TEST_CASE("a thin rod without lateral contraction stretches at n c / 2 L") {
  // With nu = 0 the one-dimensional wave is an exact solution in three dimensions.
  Material m = find_material("steel");
  m.poisson[0] = 0;
  const double length = .4, speed = m.bar_speed();
  const Mesh mesh =
      make_shape("bar", {{"length", length}, {"width", .02}, {"thickness", .02}}, {}, {});
  const auto a = solve_modes(mesh, m, 24);
  for (const int n : {1, 2}) // quadratic elements, a sixteenth of the length: (k h)^4 / 1440
    CHECK(occurrences(a.modes, n * speed / (2 * length), n == 1 ? 2e-6 : 2e-5) >= 1);
}

TEST_CASE("the thick plate of NAFEMS FV52 has its known frequencies") {
  // 10 x 10 x 1 m, w = 0 along the four lower edges, the prescribed mesh of 4 x 4 x 1 hex20.
  Material m;
  m.young_pa[0] = 2e11;
  m.poisson[0] = .3;
  m.density = 8000;
  const std::array<double, 5> across{0, 2.5, 5, 7.5, 10};
  const std::array<double, 2> through{0, 1};
  Mesh mesh = block(across, across, through);
  Support edges{"edges", {}, {false, false, true}, 0};
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const Vec3& p = mesh.nodes[i];
    if (p.z == 0 && (p.x == 0 || p.x == 10 || p.y == 0 || p.y == 10))
      edges.nodes.push_back(static_cast<int>(i));
  }
  const auto a = solve_modes(mesh, m, 7, std::span(&edges, 1));
  CHECK(a.modes.rigid == 3);
  const std::array known{44.80, 110.54, 110.54, 169.10, 193.93, 206.64, 206.64};
  for (std::size_t k = 0; k < known.size(); ++k)
    check_close(a.modes.frequency_hz[k], known[k], .001);
}

TEST_CASE("rigid motions are counted, not assumed") {
  const Material m = find_material("steel");
  const Mesh box =
      make_shape("bar", {{"length", .1}, {"width", .02}, {"thickness", .01}}, {}, {.h = .02});
  const auto count = [&](const Mesh& mesh, const std::vector<Support>& supports) {
    return solve_modes(mesh, m, 2, supports).modes.rigid;
  };
  CHECK(count(box, {}) == 6);
  CHECK(count(box, {{"end", nodes_on(box, 0, .05), {true, true, true}, 0}}) == 0);
  CHECK(count(box, {{"end", nodes_on(box, 0, .05), {true, false, false}, 0}}) ==
        3); // slides and spins
  std::vector<int> hinge;
  for (const int n : nodes_on(box, 1, -.01))
    if (std::abs(box.nodes[static_cast<std::size_t>(n)].z + .005) < 1e-9)
      hinge.push_back(n);
  CHECK(count(box, {{"hinge", hinge, {true, true, true}, 0}}) == 1);
  CHECK(count(box, {{"springs", nodes_on(box, 0, .05), {true, true, true}, 1e3}}) == 0);
  CHECK(count(two_of(box, {0, 0, .1}), {}) == 12);
}

TEST_CASE("a stiff block on soft springs rings at sqrt(k / m)") {
  const Material m = find_material("steel");
  const Mesh mesh =
      make_shape("plate", {{"length", .05}, {"width", .05}, {"thickness", .05}}, {}, {.h = .02});
  const double stiffness = 1000, mass = m.density * .05 * .05 * .05;
  std::vector<int> all;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    all.push_back(static_cast<int>(i));
  const Support springs{"springs", all, {false, false, true}, stiffness};
  const auto a = solve_modes(mesh, m, 3, std::span(&springs, 1));
  CHECK(a.modes.rigid == 3);
  CHECK(occurrences(a.modes, std::sqrt(stiffness / mass) / (2 * kPi), 1e-5) >= 1);
}

TEST_CASE("frequencies of a wooden board turn with its grain and body") {
  Material m = find_material("spruce");
  const Mesh straight =
      make_shape("board", {{"length", .3}, {"width", .2}, {"thickness", .006}}, {}, {.h = .04});
  Mesh turned = straight;
  const double c = std::cos(.7), s = std::sin(.7);
  const auto turn = [&](const Vec3& p) { return Vec3{c * p.x - s * p.z, p.y, s * p.x + c * p.z}; };
  for (Vec3& p : turned.nodes)
    p = turn(p);
  const auto a = solve_modes(straight, m, 6);
  m.axis_1 = turn(m.axis_1);
  m.axis_2 = turn(m.axis_2);
  const auto b = solve_modes(turned, m, 6);
  for (std::size_t k = 0; k < 6; ++k)
    check_close(b.modes.frequency_hz[k], a.modes.frequency_hz[k], 1e-7);
}

TEST_CASE("a spruce bar along the grain bends as a Timoshenko beam of its moduli") {
  // Slender bar, bending in x z: Timoshenko with E1, G13 and kappa = 5/6 for nu-free
  // cross-sections.
  const Material m = find_material("spruce");
  const double l = .5, t = .01;
  const auto a = solve_modes(
      make_shape("bar", {{"length", l}, {"width", .004}, {"thickness", t}}, {}, {}), m, 8);
  // Free-free Euler-Bernoulli, then the first-order shear and rotary correction (Goens 1931).
  const double bernoulli = 22.3733 / (2 * kPi * l * l) * m.bar_speed() * t / std::sqrt(12.0);
  const double shear = m.young_pa[0] / (5.0 / 6 * m.shear_pa[1]);
  const double ratio = t * t / (12 * l * l);
  const double corrected = bernoulli / std::sqrt(1 + ratio * (49.48 + shear * 12.30));
  CHECK(occurrences(a.modes, corrected, 3e-3) >= 1);
}

TEST_CASE("rescaling a body rescales its modes exactly") {
  // f goes as sqrt(E / rho) / L, mass-normalised shapes as 1 / sqrt(rho L^3).
  Material m = find_material("brass");
  const Mesh small = make_shape("disk", {{"diameter", .1}, {"thickness", .012}}, {}, {.h = .02});
  Mesh large = small;
  for (Vec3& p : large.nodes)
    p = 2.5 * p;
  const auto a = solve_modes(small, m, 6);
  m.young_pa[0] *= 1.7;
  m.density *= .6;
  const auto b = solve_modes(large, m, 6);
  const double pitch = std::sqrt(1.7 / .6) / 2.5, scale = 1 / std::sqrt(.6 * 2.5 * 2.5 * 2.5);
  for (std::size_t k = 0; k < 6; ++k)
    check_close(b.modes.frequency_hz[k], pitch * a.modes.frequency_hz[k], 1e-6);
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < a.matrices.dofs(); ++i) { // the third mode is single
    worst = std::max(worst, std::abs(b.modes.shapes[2 * a.matrices.dofs() + i] -
                                     scale * a.modes.shapes[2 * a.matrices.dofs() + i]));
    largest = std::max(largest, std::abs(b.modes.shapes[2 * a.matrices.dofs() + i]));
  }
  CHECK(worst < 1e-5 * largest);
}

TEST_CASE("the slope over Poisson's ratio predicts a body solved anew") {
  Material m = find_material("aluminium");
  const Mesh mesh = make_shape("disk", {{"diameter", .1}, {"thickness", .012}}, {}, {.h = .02});
  const auto a = solve_modes(mesh, m, 6);
  const auto slopes = poisson_slopes(mesh, std::span(&m, 1), a.matrices, a.modes);
  m.poisson[0] += .01;
  const auto b = solve_modes(mesh, m, 6);
  for (std::size_t k = 0; k < 6; ++k) // second order in the step
    CHECK(std::abs(std::log(b.modes.frequency_hz[k] / a.modes.frequency_hz[k]) - .01 * slopes[k]) <
          2e-4);
}

TEST_CASE("a body's last pair of modes is whole, so that it sounds alike turned by a right angle") {
  // The fourth and fifth modes of a free square plate are one pair (Leissa 1969: 34.8 and 34.8).
  const SolvedModes a = solve_modes(
      make_shape("plate", {{"length", .1}, {"width", .1}, {"thickness", .005}}, {}, {.h = .02}),
      find_material("steel"), 4);
  CHECK(a.modes.frequency_hz.size() == 5);
  CHECK(a.modes.multiplicity.back() == 2);
  const auto compliance = [&](const Vec3& at) { // of a strike along z, m/N
    std::size_t node = 0;
    for (std::size_t i = 0; i < a.mesh.nodes.size(); ++i)
      if (length(a.mesh.nodes[i] - at) < length(a.mesh.nodes[node] - at))
        node = i;
    CHECK(length(a.mesh.nodes[node] - at) < 1e-9);
    double sum = 0;
    for (std::size_t k = 0; k < a.modes.frequency_hz.size(); ++k)
      sum += std::pow(a.modes.shapes[k * a.mesh.dofs() + 3 * node + 2] /
                          (2 * std::numbers::pi * a.modes.frequency_hz[k]),
                      2);
    return sum;
  };
  for (const Vec3& p : a.mesh.nodes)
    if (std::abs(p.z - .0025) < 1e-9)
      check_close(compliance({-p.y, p.x, p.z}), compliance(p), 1e-3);
}

TEST_CASE("two materials share the loss by their strain energy") {
  const std::array<double, 3> xs{0, .05, .1};
  const std::array<double, 3> ys{0, .005, .01};
  Mesh mesh = block(xs, ys, ys);
  mesh.regions = {"left", "right"};
  for (Element& e : mesh.elements)
    e.region = mesh.nodes[static_cast<std::size_t>(mesh.nodes_of(e)[0])].x < .049 ? 0 : 1;
  const std::vector<Material> same{find_material("steel"), find_material("steel")};
  std::vector<Material> mixed = same;
  mixed[1].loss_factor = 1e-2;
  const Matrices m = assemble(mesh, mixed, {});
  ModeSettings settings;
  settings.count = 3;
  const Modes modes = find_modes(mesh, mixed, m, settings);
  const auto alone = loss_factors(mesh, same, m, modes), both = loss_factors(mesh, mixed, m, modes);
  for (std::size_t k = 0; k < 3; ++k) { // mirror-symmetric: half the energy each
    CHECK(alone[k] == doctest::Approx(same[0].loss_factor).epsilon(1e-6));
    CHECK(both[k] == doctest::Approx(.5 * (same[0].loss_factor + 1e-2)).epsilon(1e-3));
  }
  // A body of one material has all of its loss; without a loss factor, Rayleigh's a/w + b w.
  std::vector<Material> one{find_material("steel")};
  for (const double loss : loss_factors(mesh, one, m, modes))
    CHECK(loss == one[0].loss_factor);
  one[0].loss_factor = 0;
  one[0].rayleigh_a = 20;
  one[0].rayleigh_b = 3e-7;
  const auto rayleigh = loss_factors(mesh, one, m, modes);
  for (std::size_t k = 0; k < 3; ++k) {
    const double w = 2 * std::numbers::pi * modes.frequency_hz[k];
    CHECK(rayleigh[k] == doctest::Approx(20 / w + 3e-7 * w));
  }
}

namespace {

/// Of the first frequency of a free cube of n^3 and (2 n)^3 cells.
double order_of_tet10(int n, double fine_size) {
  const Material m = find_material("steel");
  const auto first = [&](Mesh mesh) {
    return solve_modes(std::move(mesh), m, 1).modes.frequency_hz[0];
  };
  const double exact = first(
      make_shape("plate", {{"length", 1}, {"width", 1}, {"thickness", 1}}, {}, {.h = fine_size}));
  const double coarse = first(tetrahedral_block(n, true)),
               fine = first(tetrahedral_block(2 * n, true));
  return std::log2((coarse - exact) / (fine - exact));
}

} // namespace

// Four in the limit.
TEST_CASE("the error of tet10 shrinks about with the third power of the size") {
  CHECK(order_of_tet10(2, 1. / 8) > 2.5);
}

TEST_CASE("the error of tet10 shrinks faster than the third power of the size" *
          doctest::test_suite("slow")) {
  CHECK(order_of_tet10(3, 1. / 12) > 3);
}

TEST_CASE("what a push yields beyond six modes is what the next ten add, and the rest") {
  // Compact and coarse: the half space under the patch is a small part.
  const auto mesh =
      make_shape("plate", {{"length", .2}, {"width", .16}, {"thickness", .004}}, {}, {.h = .03});
  const Material steel = find_material("steel");
  const SolvedModes few = solve_modes(mesh, steel, 6), many = solve_modes(mesh, steel, 60);
  const std::vector<Material> materials{steel};
  const Surface skin = surface_of(mesh);
  const auto beyond_few = residual_compliance(mesh, materials, few.matrices, few.modes, 1)[0];
  const auto beyond_many = residual_compliance(mesh, materials, many.matrices, many.modes, 1)[0];
  double edge = 0;
  for (const auto& t : skin.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      edge +=
          length(mesh.nodes[static_cast<std::size_t>(skin.node[static_cast<std::size_t>(t[k])])] -
                 mesh.nodes[static_cast<std::size_t>(
                     skin.node[static_cast<std::size_t>(t[(k + 1) % 3])])]);
  const PushPatch patch =
      push_patch(mesh, skin, 0, edge / static_cast<double>(skin.triangles.size()));
  double added = 0;
  for (std::size_t k = 6; k < 60; ++k) {
    double along = 0;
    for (std::size_t i = 0; i < patch.node.size(); ++i) {
      const double* u = &many.modes.shapes[k * mesh.dofs() + 3 * patch.node[i]];
      along += dot(patch.force[i], {u[0], u[1], u[2]});
    }
    added += std::pow(along / (2 * std::numbers::pi * many.modes.frequency_hz[k]), 2);
  }
  CHECK(beyond_many > 0);
  CHECK(beyond_few > 1.5 * beyond_many); // bending goes mostly into the first sixty
  CHECK(double(beyond_few - beyond_many) == doctest::Approx(added).epsilon(2e-3));
}

// The disks of the AudioHaptics paper against a body-of-revolution solver (Fourier harmonics around
// the axis, spectral quadrilaterals of order 4 to 8; digits stable to 1e-5).
#include "solve.hpp"

#include <algorithm>
#include <numbers>
#include <numeric>

using namespace tactus::fem;
using tactus::Vec3;

namespace {
const Material kAluminium = find_material("aluminium");

/// The first ten within one bound, the next ten within another.
void check_against(const std::vector<double>& found, const std::vector<double>& exact,
                   double first_ten, double first_twenty) {
  REQUIRE(exact.size() == 20);
  for (std::size_t k = 0; k < 20; ++k) {
    CAPTURE(k);
    check_close(found[k], exact[k], k < 10 ? first_ten : first_twenty);
  }
}
} // namespace

TEST_CASE("solid disks have the frequencies of the axisymmetric solution" *
          doctest::test_suite("slow")) {
  struct Solid {
    double thickness;
    std::vector<double> exact;
  };
  for (const auto& [thickness, exact] :
       {Solid{.012, {5890.390,  5890.390,  9992.755,  12864.666, 12864.666, 20574.586, 20574.586,
                     21111.257, 21111.257, 23364.669, 23364.669, 27421.217, 27421.217, 30197.524,
                     30197.524, 32156.676, 32156.676, 34887.145, 35445.500, 35892.833}},
        Solid{.025, {10688.927, 10688.927, 17365.377, 21149.109, 21149.109, 23363.671, 23363.671,
                     27371.925, 27371.925, 31079.559, 31079.559, 32006.568, 32006.568, 34991.794,
                     35878.489, 35878.489, 42330.901, 42330.901, 42906.667, 42906.667}}}) {
    const auto a = solve_modes(
        make_shape("disk", {{"diameter", .1}, {"thickness", thickness}}, {}, {}), kAluminium, 20);
    CHECK(a.mesh.dofs() <= 60000);
    CHECK(a.modes.rigid == 6);
    check_against(a.modes.frequency_hz, exact, .0015, .003);
    check_close(mass_properties(a.mesh, std::span(&kAluminium, 1)).mass,
                2700 * std::numbers::pi * .0025 * thickness, 1e-5);
    for (std::size_t k = 0; k + 1 < 20; ++k)
      if (exact[k] == exact[k + 1])
        check_close(a.modes.frequency_hz[k + 1], a.modes.frequency_hz[k], 2e-4);
    for (const double residual : a.modes.residual)
      CHECK(residual < 1e-6);
  }
}

TEST_CASE("the hollow disk's mesh is graded to its inner edges" * doctest::test_suite("slow")) {
  const std::map<std::string, double> hollow{
      {"diameter", .1}, {"thickness", .025}, {"cavity_diameter", .08}, {"cavity_thickness", .013}};
  const auto a = solve_modes(make_shape("hollow_disk", hollow, {}, {.h = .008}), kAluminium, 20);
  CHECK(a.mesh.dofs() <= 100000);
  check_against(a.modes.frequency_hz,
                {7308.224,  8825.272,  9835.904,  9835.904,  11982.289, 11982.289, 14620.028,
                 14620.028, 19075.348, 19075.348, 19177.265, 19177.265, 20271.910, 20271.910,
                 22083.937, 22083.937, 23152.617, 23152.617, 25304.991, 25856.110},
                .005, .01);
  // A solid disk sounds higher than the hollow one, by 46 %.
  check_close(10688.927 / a.modes.frequency_hz[0], 1.463, .03);
  // The stress in the corner grows as r^-0.456: without grading the first mode is far too stiff.
  const auto b = solve_modes(
      make_shape("hollow_disk", hollow, {}, {.h = .008, .grade_concave = false}), kAluminium, 2);
  CHECK(b.modes.frequency_hz[0] / 7308.224 - 1 >
        5 * std::abs(a.modes.frequency_hz[0] / 7308.224 - 1));
}

TEST_CASE("held at the centre of its back the disk has an umbrella mode near 3.7 kHz" *
          doctest::test_suite("slow")) {
  // Edge of a clamped patch: the stress is singular there, hence 4 % for modes that bend at it.
  Mesh mesh = make_shape("disk", {{"diameter", .1}, {"thickness", .012}, {"patch_diameter", .004}},
                         {}, {.h = .0085});
  Support patch{"patch", {}, {true, true, true}, 0};
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    if (length(mesh.nodes[i] - Vec3{0, 0, -.006}) < .002 + 1e-9)
      patch.nodes.push_back(static_cast<int>(i));
  const auto a = solve_modes(std::move(mesh), kAluminium, 16, std::span(&patch, 1));
  CHECK(a.modes.rigid == 0);
  const auto near = [&](double frequency) {
    double best = 1e9;
    for (const double f : a.modes.frequency_hz)
      best = std::min(best, std::abs(f / frequency - 1));
    return best;
  };
  CHECK(near(3667) < .04);
  CHECK(near(14885) < .04);
  CHECK(near(5893) < .002);
}

TEST_CASE("a coarse disk has the frequencies of the axisymmetric solution within 1.2 %, and "
          "the same bits again, also in its pairs") {
  const auto solve = [] {
    return solve_modes(make_shape("disk", {{"diameter", .1}, {"thickness", .012}}, {}, {.h = .02}),
                       kAluminium, 8);
  };
  const auto a = solve(), b = solve();
  const std::array exact{5890.390, 5890.390, 9992.755, 12864.666, 12864.666};
  for (std::size_t k = 0; k < exact.size(); ++k)
    check_close(a.modes.frequency_hz[k], exact[k], .012);
  CHECK(a.modes.shapes == b.modes.shapes);
  CHECK(a.modes.frequency_hz == b.modes.frequency_hz);
  // The first of a pair has its antinode on +x, so the second is at rest there.
  const auto n = a.matrices.dofs();
  std::size_t rim = 0;
  for (std::size_t i = 0; i < a.mesh.nodes.size(); ++i)
    if (a.mesh.nodes[i].x > a.mesh.nodes[rim].x)
      rim = i;
  const auto moves = [&](std::size_t k) { return std::abs(a.modes.shapes[k * n + 3 * rim + 2]); };
  CHECK(moves(1) < 1e-3 * moves(0)); // across the plate; in its plane the second slides there
}

TEST_CASE("an uneven disk's pair keeps both frequencies, however its shapes are turned") {
  Mesh mesh = make_shape("disk", {{"diameter", .1}, {"thickness", .012}}, {}, {.h = .02});
  // An ellipse with its axes at 45 degrees parts the modes of one diameter.
  for (Vec3& p : mesh.nodes)
    p = {p.x + 5e-5 * p.y, p.y + 5e-5 * p.x, p.z};
  constexpr std::size_t kFirst = 5, kCount = 7;
  const auto a = solve_modes(std::move(mesh), kAluminium, kCount);
  const std::size_t n = a.matrices.dofs();
  std::vector<double> stiff(kCount * n);
  a.matrices.multiply_stiffness(a.modes.shapes, stiff, kCount);
  const auto energy = [&](std::size_t i, std::size_t j) {
    const auto shape = a.modes.shapes.begin() + static_cast<std::ptrdiff_t>((kFirst + i) * n);
    return std::inner_product(shape, shape + static_cast<std::ptrdiff_t>(n),
                              &stiff[(kFirst + j) * n], 0.0);
  };
  // The eigenvalues of the stiffness within the pair's plane.
  const double middle = (energy(0, 0) + energy(1, 1)) / 2;
  const double difference = std::hypot((energy(0, 0) - energy(1, 1)) / 2, energy(0, 1));
  const auto hertz = [](double lambda) { return std::sqrt(lambda) / (2 * std::numbers::pi); };
  CHECK(difference > 1e-5 * middle);
  CHECK(a.modes.frequency_hz[kFirst] == doctest::Approx(hertz(middle - difference)).epsilon(1e-9));
  CHECK(a.modes.frequency_hz[kFirst + 1] ==
        doctest::Approx(hertz(middle + difference)).epsilon(1e-9));
  CHECK(std::abs(energy(0, 0) - energy(1, 1)) < .5 * difference); // the shapes were turned
  for (const double residual : a.modes.residual)
    CHECK(residual < 1e-6);
}

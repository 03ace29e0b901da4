// A body's material and size: what moves, decays, recoils and gives way, by the laws of elasticity.
#include "core/haptic/scene/pose.hpp"
#include "tests/approx.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::haptic::cross;
using tactus::haptic::dot;

namespace {

constexpr double kPi = std::numbers::pi;

/// The closed form's plate, let go: with inertia that is no cube's, slopes, radiation and what lies
/// beyond.
ModalTable free_plate() {
  ModalTable table = plate(.32, .2, .005, 3000, 16, 10);
  table.free = true;
  table.centre_of_mass_m = {.01, -.02, 0};
  table.inertia_kg_m2 = {Vec3{4e-3, 5e-4, -2e-4}, Vec3{5e-4, 9e-3, 3e-4},
                         Vec3{-2e-4, 3e-4, 1.2e-2}};
  table.residual_compliance.assign(table.vertices(), 0);
  for (std::size_t v = 0; v < table.vertices();
       ++v) // straight over the surface: exact between vertices
    table.residual_compliance[v] = static_cast<float>(1e-8 * (2 + 3 * table.vertex_m[v].x));
  for (std::size_t k = 0; k < table.modes(); ++k) {
    table.radiation_decay_rate.push_back(2 + static_cast<double>(k));
    table.poisson_slope.push_back(.1 + .01 * static_cast<double>(k));
  }
  return table;
}

struct Body {
  std::shared_ptr<const LoadedTable> loaded = std::make_shared<const LoadedTable>(free_plate());
  BodySettings settings;
  Body() { settings.radiation = Radiation::kNone; }
  [[nodiscard]] BodyModel model() const { return BodyModel(loaded, settings); }
};

std::complex<double> rate(const BodyModel& model, std::size_t mode) {
  return model.rate[model.index_of[mode]];
}

double square(const std::array<double, ContactSolver::kRigid>& gain) {
  double sum = 0;
  for (const double b : gain)
    sum += b * b;
  return sum;
}

/// 1/m + (r x n) I^-1 (r x n), Cramer's rule.
double mobility(double mass, const std::array<Vec3, 3>& inertia, const Vec3& arm, const Vec3& n) {
  const Vec3 turn = cross(arm, n);
  const auto det = [](const Vec3& a, const Vec3& b, const Vec3& c) { return dot(a, cross(b, c)); };
  const Vec3 &a = inertia[0], &b = inertia[1], &c = inertia[2]; // symmetric: rows are columns
  const double whole = det(a, b, c);
  const Vec3 w{det(turn, b, c) / whole, det(a, turn, c) / whole, det(a, b, turn) / whole};
  return 1 / mass + dot(turn, w);
}

} // namespace

TEST_CASE("a free body's recoil is that of its mass and inertia, in any size and density") {
  Body body;
  const ModalTable table = free_plate();
  for (const double size : {1., 2., .5})
    for (const double density : {2700., 7800.}) {
      CAPTURE(size);
      CAPTURE(density);
      body.settings.size = size;
      body.settings.density_kg_per_m3 = density;
      const BodyModel model = body.model();
      const double heavier = density / 2700;
      CHECK(model.mass_kg == approx(table.mass_kg * heavier * std::pow(size, 3)));
      std::array<Vec3, 3> inertia = table.inertia_kg_m2;
      for (Vec3& row : inertia)
        row = row * (heavier * std::pow(size, 5));
      for (const Vec3& point :
           {Vec3{.1, .07, .0025}, Vec3{-.13, .02, .0025}, Vec3{0, -.09, .0025}}) {
        const SurfacePoint at = model.nearest(size * point);
        const Vec3 arm = size * (point - table.centre_of_mass_m);
        for (const Vec3& n : {Vec3{0, 0, 1}, Vec3{.6, 0, .8}, Vec3{.48, -.6, .64}})
          CHECK(square(model.rigid_gains(at, n)) ==
                approx(mobility(model.mass_kg, inertia, arm, n)).epsilon(1e-6));
      }
    }
}

TEST_CASE("residual compliance scales as 1 over modulus and size") {
  Body body;
  const auto compliance = [&](double size, double modulus) {
    body.settings.size = size;
    body.settings.youngs_modulus_pa = modulus;
    const BodyModel model = body.model();
    return model.residual_compliance(model.nearest(size * Vec3{.05, .03, .0025}));
  };
  const double own = compliance(1, 0);
  CHECK(own == approx(1e-8 * (2 + 3 * .05)).epsilon(1e-5));
  CHECK(compliance(2, 0) == approx(own / 2).epsilon(1e-6));
  CHECK(compliance(.25, 0) == approx(own * 4).epsilon(1e-6));
  CHECK(compliance(1, 2 * 70.3e9) == approx(own / 2).epsilon(1e-6));
  CHECK(compliance(3, 70.3e9 / 3) == approx(own).epsilon(1e-6));
}

TEST_CASE("frequencies follow modulus, density, size and Poisson's ratio") {
  Body body;
  const BodyModel own = body.model();
  const double f = rate(own, 3).imag();
  const ModalTable table = free_plate();
  CHECK(f == approx(2 * kPi * table.frequency_hz[3]));
  body.settings.youngs_modulus_pa = 9 * 70.3e9;
  CHECK(rate(body.model(), 3).imag() == approx(3 * f));
  body.settings.density_kg_per_m3 = 4 * 2700;
  CHECK(rate(body.model(), 3).imag() == approx(1.5 * f));
  body.settings.size = 3;
  CHECK(rate(body.model(), 3).imag() == approx(.5 * f));
  body.settings = {};
  body.settings.radiation = Radiation::kNone;
  body.settings.poisson = .33 + .05;
  CHECK(rate(body.model(), 3).imag() == approx(f * std::exp(.05 * .13)).epsilon(1e-3));
  body.settings.poisson = .33;
  CHECK(rate(body.model(), 3).imag() == approx(f));
}

TEST_CASE("decay is the material's, the radiation's and the choke's together") {
  Body body;
  BodySettings& s = body.settings;
  const ModalTable table = free_plate();
  const std::size_t k = 4;
  const double omega = 2 * kPi * table.frequency_hz[k], air = table.radiation_decay_rate[k];
  const auto decay = [&] { return -rate(body.model(), k).real(); };
  const double own = decay() - air; // of the table
  CHECK(own > 0);
  s.choke_t60_s = .5;
  CHECK(decay() == approx(own + air + std::log(1000.) / .5));
  s.choke_t60_s = 0;
  s.damping = Damping::kLoss;
  s.loss_factor = .004;
  CHECK(decay() == approx(.5 * omega * .004 + air));
  s.damping = Damping::kRayleigh;
  s.rayleigh_a_per_s = 3;
  s.rayleigh_b_s = 2e-7;
  CHECK(decay() == approx(.5 * (3 + 2e-7 * omega * omega) + air));
  s.damping = Damping::kCurve;
  const double f = table.frequency_hz[k];
  s.loss_curve = {{f / 2, .001}, {2 * f, .003}}; // logarithms on a straight line: their mean at f
  CHECK(decay() == approx(.5 * omega * std::sqrt(.001 * .003) + air).epsilon(1e-6));
  s.loss_curve = {{2 * f, .003}, {4 * f, .001}}; // level before the first and after the last
  CHECK(decay() == approx(.5 * omega * .003 + air).epsilon(1e-6));
  s.loss_curve = {{f / 4, .003}, {f / 2, .001}};
  CHECK(decay() == approx(.5 * omega * .001 + air).epsilon(1e-6));
  // Radiation: rho_air c area/mass at the same shape: as 1/(rho L); the rest is as without it.
  s.damping = Damping::kLoss;
  s.size = 2;
  CHECK(decay() == approx(.5 * omega / 2 * .004 + air / 2));
  s.density_kg_per_m3 = 3 * 2700;
  CHECK(decay() == approx(.5 * omega / 2 / std::sqrt(3.) * .004 + air / 6));
}

#include "core/contact/excited_body.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

// Laws by their closed forms, and what happens at the ends of ranges.

using namespace tactus::contact;
using tactus::test::approx;

namespace {

constexpr double kRate = 48000;
const std::vector<Mode> kModes{{300, .5, .4}, {910, .3, .3}, {2230, .2, .5}};
const std::vector<double> kShapeA{1, -.6, .8}, kShapeB{.7, .9, -.4};

ExcitedBody make_body(std::size_t exciters) {
  ExcitedBody body(kModes.size(), exciters, 1);
  body.prepare(kRate);
  body.set_modes(kModes);
  body.set_contact_shape(0, kShapeA);
  if (exciters > 1)
    body.set_contact_shape(1, kShapeB);
  return body;
}

} // namespace

TEST_CASE(
    "restitution solves y - ln(1 + y) = -e y - ln(1 - e y), and is its series for weak losses") {
  CHECK(restitution(0) == 1);
  CHECK(restitution(-1) == 1);
  for (const double y : {.01, .1, .5, 2., 20.}) {
    const double e = restitution(y);
    CHECK(-e * y - std::log1p(-e * y) == approx(y - std::log1p(y)).epsilon(1e-7));
  }
  for (const double y : {1e-9, 1e-6, 9.9e-5, 1.01e-4, 1e-3})
    CHECK(restitution(y) == approx(1 - 2. / 3 * y + 4. / 9 * y * y).epsilon(1e-9));
  CHECK(restitution(1e6) == approx(1e-6).epsilon(1e-3));
}

TEST_CASE("numbers of laws are held within their ranges, and nonsense is the usual") {
  const ImpactLaw held = ImpactLaw{1e99, 99, -3}.within_range();
  CHECK(held.stiffness == 1e18);
  CHECK(held.exponent == 6);
  CHECK(held.dissipation_s_per_m == 0);
  const ImpactLaw odd = ImpactLaw{std::nan(""), 0, 1e9}.within_range();
  CHECK(odd.stiffness == ImpactLaw{}.stiffness);
  CHECK(odd.exponent == 1);
  CHECK(odd.dissipation_s_per_m == 1e6);
  const FrictionLaw f = FrictionLaw{.1, .5, 1e9, 2, 1e99, -1, 1e99, std::nan("")}.within_range();
  CHECK(f.static_coefficient == .5); // not below the dynamic one
  CHECK(f.stribeck_m_per_s == 1e3);
  CHECK(f.breakaway == .99);
  CHECK(f.stiffness_n_per_m == 1e12);
  CHECK(f.damping_ns_per_m == 0);
  CHECK(f.viscosity_ns_per_m == 1e9);
  CHECK(f.roughness == FrictionLaw{}.roughness);
}

TEST_CASE("bristles that have been released bend from nothing, and stiffer ones hold no more") {
  Friction used, fresh;
  const auto force = [](Friction& friction, int steps) {
    double last = 0;
    for (int n = 0; n < steps; ++n) {
      friction.enter_step(10, .05, 0, 1 / kRate);
      friction.refine(.05);
      last = friction.force(.05, 0);
      friction.pass_step(.05);
    }
    return last;
  };
  force(used, 3000);
  CHECK(used.stored_j() > 0);
  used.release();
  CHECK(used.stored_j() == 0);
  CHECK(force(used, 40) == force(fresh, 40));
  const double stored = used.stored_j();
  FrictionLaw stiff;
  stiff.stiffness_n_per_m *= 100;
  used.set(stiff);
  CHECK(used.stored_j() == approx(stored));
  used.enter_step(0, 1, 0, 1 / kRate); // nothing presses
  CHECK(used.stored_j() == 0);
}

TEST_CASE("a mass flies no further than a kilometre, and falls back from there") {
  ExcitedBody body = make_body(1);
  body.set_impact(0, {1e6, 1.5, 0}, .1);
  body.launch_mass(0, 500, -9000);
  for (int n = 0; n < 48000; ++n)
    body.step();
  CHECK(body.exciter(0).position_m == -1000);
  CHECK(body.exciter(0).velocity_m_per_s == 0);
  body.set_mass_force(0, 1e3); // 1e4 m/s^2, but no faster than 1e4 m/s
  int samples = 0;
  while (body.exciter(0).impact_count == 0 && samples < 96000) {
    body.step();
    ++samples;
  }
  CHECK(samples / kRate == approx(std::sqrt(2 * 1000 / 1e4)).epsilon(.01));
}

TEST_CASE("masses that come and go leave the others alone") {
  // One mass held on the body by a force; another strikes elsewhere and leaves, is taken away, is
  // thrown again: the first is at its depth afterwards.
  ExcitedBody body = make_body(2);
  body.set_impact(0, {1e6, 1.5, .5}, .05);
  body.launch_mass(0, 0, 0);
  body.set_mass_force(0, 2);
  for (int n = 0; n < 96000; ++n)
    body.step();
  const double rest = body.exciter(0).depth_m;
  // k x^1.5 = 2 N
  CHECK(rest == approx(std::pow(2e-6, 2. / 3)).epsilon(1e-3));
  for (int round = 0; round < 3; ++round) {
    body.set_impact(1, {1e8, 1.5, .1}, .01);
    body.launch_mass(1, 1e-4, .5);
    for (int n = 0; n < 4000; ++n)
      body.step();
    CHECK(body.exciter(1).impact_count > 0);
    body.clear(1);
    CHECK(body.force(1) == 0);
    for (int n = 0; n < 96000; ++n)
      body.step();
    CHECK(body.exciter(0).depth_m == approx(rest).epsilon(1e-3));
    CHECK(body.steps() <= 4);
  }
}

TEST_CASE("steps grow fine under a hard strike and coarse again after it") {
  ExcitedBody body = make_body(1);
  body.set_impact(0, {1e10, 1.5, .1}, .02);
  body.launch_mass(0, 1e-4, 2);
  unsigned maximum = 0;
  for (int n = 0; n < 200; ++n) {
    body.step();
    maximum = std::max(maximum, body.steps());
  }
  CHECK(maximum >= 8);
  for (int n = 0; n < 2000; ++n)
    body.step();
  CHECK(body.steps() == 1);
  body.set_min_steps(8);
  body.step();
  CHECK(body.steps() == 8);
  body.set_min_steps(1000);
  body.step();
  CHECK(body.steps() == 64);
}

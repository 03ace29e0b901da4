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

TEST_CASE("force, work and depth of the law belong together") {
  for (const double exponent : {1., 1.5, 2.7}) {
    const ImpactLaw law{3e6, exponent, .4};
    const double x = 2e-4, dx = 1e-9;
    CHECK(law.force(x, 0) == approx(3e6 * std::pow(x, exponent)));
    CHECK(law.force(x, .5) == approx(law.force(x, 0) * 1.2));
    CHECK(law.force(x, -9) == 0); // never pulls
    CHECK(law.force(0, 1) == 0);
    CHECK(law.force(-x, 1) == 0);
    CHECK((law.work(x + dx) - law.work(x - dx)) / (2 * dx) ==
          approx(law.force(x, 0)).epsilon(1e-5));
    CHECK(law.work(0) == 0);
    CHECK(law.work(-x) == 0);
    CHECK(law.deepest(law.work(x)) == approx(x));
    CHECK(law.deepest(0) == 0);
    CHECK(law.deepest(-1) == 0);
  }
  const ImpactLaw held = ImpactLaw{1e99, 99, -3}.within_range();
  CHECK(held.stiffness == 1e18);
  CHECK(held.exponent == 6);
  CHECK(held.dissipation_s_per_m == 0);
  const ImpactLaw odd = ImpactLaw{std::nan(""), 0, 1e9}.within_range();
  CHECK(odd.stiffness == ImpactLaw{}.stiffness);
  CHECK(odd.exponent == 1);
  CHECK(odd.dissipation_s_per_m == 1e6);
}

TEST_CASE("restitution of weak losses is its series, and that of none is one") {
  CHECK(restitution(0) == 1);
  CHECK(restitution(-1) == 1);
  for (const double y : {1e-9, 1e-6, 9.9e-5, 1.01e-4, 1e-3}) {
    // y - ln(1 + y) is the same at y and -e y: e = 1 - 2/3 y + 4/9 y^2 - ...
    CHECK(restitution(y) == approx(1 - 2. / 3 * y + 4. / 9 * y * y).epsilon(1e-9));
  }
}

TEST_CASE("friction's ranges hold, and what has been released bends from nothing") {
  const FrictionLaw held = FrictionLaw{.1, .5, 1e9, 2, 1e99, -1, 1e99, std::nan("")}.within_range();
  CHECK(held.static_coefficient == .5); // not below the dynamic one
  CHECK(held.stribeck_m_per_s == 1e3);
  CHECK(held.breakaway == .99);
  CHECK(held.stiffness_n_per_m == 1e12);
  CHECK(held.damping_ns_per_m == 0);
  CHECK(held.viscosity_ns_per_m == 1e9);
  CHECK(held.roughness == FrictionLaw{}.roughness);
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
  CHECK(force(used, 1) == force(fresh, 1));
  CHECK(force(used, 40) == force(fresh, 40));
  // Stiffer bristles hold no more than the softer ones did.
  const double stored = used.stored_j();
  FrictionLaw stiff;
  stiff.stiffness_n_per_m *= 100;
  used.set(stiff);
  CHECK(used.stored_j() == approx(stored));
  used.enter_step(0, 1, 0, 1 / kRate); // nothing presses
  CHECK(used.stored_j() == 0);
}

TEST_CASE("a force from outside moves the body as if nothing were near, or two masses that do not "
          "touch") {
  ExcitedBody alone = make_body(2), beside = make_body(2);
  for (const std::size_t slot : {0UL, 1UL}) {
    beside.set_impact(slot, {1e7, 1.5, 0}, .02);
    beside.launch_mass(slot, 2e-6,
                       0); // near: within two samples of a moving surface, and never reached
  }
  double apart = 0, size = 0;
  for (int n = 0; n < 400; ++n) {
    const double force = 1e-3 * std::sin(.05 * n);
    alone.apply_force(0, force);
    beside.apply_force(0, force);
    alone.apply_force(1, -.5 * force);
    beside.apply_force(1, -.5 * force);
    alone.step();
    beside.step();
    apart = std::max(apart, std::abs(alone.pickup_velocity() - beside.pickup_velocity()));
    size = std::max(size, std::abs(alone.pickup_velocity()));
  }
  CHECK(beside.force(0) == 0);
  CHECK(size > 1e-7);
  CHECK(apart < 1e-12 * size);
}

TEST_CASE("two contacts too short for steps are impulses, at one moment") {
  ExcitedBody body = make_body(2);
  for (const std::size_t slot : {0UL, 1UL}) {
    body.set_impact(slot, {1e17, 1.5, .2}, .01);
    body.launch_mass(slot, 1e-6, 1);
  }
  const double before = body.energy();
  for (int n = 0; n < 4; ++n)
    body.step();
  for (const std::size_t slot : {0UL, 1UL}) {
    CHECK(body.exciter(slot).impact_count >= 1);
    CHECK(body.exciter(slot).last.duration_s == 0);
    CHECK(body.exciter(slot).last.impulse_ns > 0);
    CHECK(body.exciter(slot).velocity_m_per_s < .5);
  }
  CHECK(body.energy() < before);
  CHECK(body.energy() > .5 * before);
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

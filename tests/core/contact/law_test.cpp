// One contact's law in steps, without a body: what it stores, how it bends, how fine it must be.
#include "core/contact/exciter.hpp"
#include "core/contact/friction.hpp"
#include "core/contact/impact.hpp"
#include "core/contact/power.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace tactus::contact;
using tactus::test::approx;

namespace {

constexpr double kRate = 48000;

} // namespace

TEST_CASE("a contact pressed slowly in and out stores the work of its law, and gives it back") {
  for (const double exponent : {1., 1.5, 2.5, 4.})
    for (const double compliance : {0., 1e-8, 1e-6, 1e-4}) {
      CAPTURE(exponent);
      CAPTURE(compliance);
      const ImpactLaw law{1e7, exponent, 0, compliance};
      Impact impact;
      impact.set(law);
      constexpr int kSteps = 2000;
      constexpr double kDeepest = 2e-4, h = 1 / kRate;
      double x = -1e-9, work = 0, worst = 0, force_error = 0;
      const double maximum = law.work(kDeepest), strongest = law.force(kDeepest, 0);
      for (int n = 0; n < 2 * kSteps; ++n) {
        const double compression = (n < kSteps ? kDeepest : -kDeepest) / kSteps,
                     rate = compression / h;
        double force = 0;
        if (Impact::in_contact(x, rate, h)) {
          const LinearForce f = impact.enter_step(x, rate, h);
          force = f.offset_n + f.slope_ns_per_m * rate;
          impact.pass_step(rate, h);
        }
        work += force * compression;
        if (x > .05 * kDeepest)
          force_error = std::max(force_error, std::abs(force - law.force(x + .5 * compression, 0)));
        x += compression;
        impact.leave_step(x);
        worst = std::max(worst, std::abs(impact.stored_j() + impact.energy_account_j() - work));
        if (n % 100 == 50)
          CHECK(impact.stored_j() == approx(law.work(x)).epsilon(1e-3));
      }
      CHECK(worst < 1e-9 * maximum);
      CHECK(force_error < 1e-3 * strongest);
      CHECK(!impact.touching());
    }
}

TEST_CASE(
    "force, indentation, work and depth of a law belong together, with a compliance in series") {
  for (const double exponent : {1., 1.5, 3., 6.})
    for (const double compliance : {0., 1e-9, 1e-6, 1e-3, 1.})
      for (const double x : {1e-7, 1e-5, 1e-3, .1}) {
        const ImpactLaw law{1e6, exponent, 0, compliance};
        const double d = law.indentation(x), force = 1e6 * std::pow(d, exponent);
        CAPTURE(exponent);
        CAPTURE(compliance);
        CAPTURE(x);
        CHECK(d + compliance * force == approx(x).epsilon(1e-9));
        CHECK(law.force(x, 0) == approx(force).epsilon(1e-9));
        CHECK(law.work(x) ==
              approx(force * d / (exponent + 1) + .5 * compliance * force * force).epsilon(1e-9));
        if (law.work(x) > 1e-40)
          CHECK(law.deepest(law.work(x)) == approx(x).epsilon(1e-6));
        // dF/dx in series, and no more than without the compliance at that energy.
        Impact impact;
        impact.set(law);
        const double stiffness = exponent * force / d, highest = impact.stiffest(law.work(x), 1);
        CHECK(highest <=
              1.001 * exponent * 1e6 *
                  std::pow(ImpactLaw{1e6, exponent, 0, 0}.deepest(law.work(x)), exponent - 1));
        if (law.work(x) > 0)
          CHECK(highest >= .999 * stiffness / (1 + compliance * stiffness));
      }
  // A compliance in series: never stiffer than it; and without energy only a spring is stiff.
  const auto stiffest = [](const ImpactLaw& law, double energy_j, double mass_kg) {
    Impact impact;
    impact.set(law);
    return impact.stiffest(energy_j, mass_kg);
  };
  CHECK(stiffest({1e12, 1, 0, 1e-5}, 1, 1) == approx(1e5).epsilon(1e-5));
  CHECK(stiffest({1e6, 1.5, 0, 0}, 0, 1) == 0);
  CHECK(stiffest({1e6, 1, 0, 0}, 0, .02) == approx(1e6 / .02));
  const ImpactLaw lossy{3e6, 1.5, .4};
  const double x = 2e-4;
  CHECK(lossy.force(x, .5) == approx(lossy.force(x, 0) * 1.2));
  CHECK(lossy.force(x, -9) == 0); // never pulls
  for (const double apart : {0., -x}) {
    CHECK(lossy.force(apart, 1) == 0);
    CHECK(lossy.work(apart) == 0);
    CHECK(lossy.deepest(apart) == 0);
  }
}

TEST_CASE("friction's first stage follows its law to the second order of the velocity's change") {
  FrictionLaw law;
  law.viscosity_ns_per_m = 0;
  for (const double speed : {.04, .07, .12, .2}) {
    Friction rubbing;
    rubbing.set(law);
    for (int n = 0; n < 4000; ++n) { // sliding
      rubbing.enter_step(10, speed, 0, 1 / kRate);
      rubbing.refine(speed);
      rubbing.pass_step(speed);
    }
    const auto force = [&](double velocity, bool anew) {
      Friction friction = rubbing;
      if (anew) // far away: it is taken there exactly, and then here
        friction.enter_step(10, 10, 0, 1 / kRate);
      friction.enter_step(10, velocity, 0, 1 / kRate);
      return friction.force(velocity, 0);
    };
    for (const double change : {-.006, -.003, .003, .006}) {
      CAPTURE(speed);
      CAPTURE(change);
      const double followed = force(speed + change, false), exact = force(speed + change, true);
      CHECK(std::abs(followed - exact) < .12 * std::abs(exact - force(speed, true)));
    }
    CHECK(force(speed, false) == approx(force(speed, true)).epsilon(1e-9));
    // Steady sliding: f = F_n (mu_d + (mu_s - mu_d) e^-(v/v_s)^2).
    CHECK(force(speed, true) ==
          approx(10 * (.3 + .5 * std::exp(-speed * speed / .01))).epsilon(1e-4));
  }
}

TEST_CASE(
    "a rough surface drags at random, as the root of force and speed, and not without bound") {
  FrictionLaw smooth, rough;
  smooth.damping_ns_per_m = rough.damping_ns_per_m = 0; // which passivity holds by the viscosity
  rough.roughness = 2;
  const auto force = [](const FrictionLaw& law, double press, double speed, double noise) {
    Friction friction;
    friction.set(law);
    friction.enter_step(press, speed, noise, 1 / kRate);
    return friction.force(speed, 0);
  };
  for (const double noise : {.5, -.5, 2.})
    for (const double press : {1., 9.})
      for (const double speed : {.2, -.2, 5e-4, -5e-4}) {
        CAPTURE(noise);
        CAPTURE(press);
        CAPTURE(speed);
        // sigma3 |w| sqrt(F_n |v|), bounded towards rest as by another 0.1 mm/s.
        const double size = std::abs(speed),
                     expected = 2 * std::abs(noise) * std::sqrt(press / (size + 1e-4)) * speed;
        CHECK(force(rough, press, speed, noise) - force(smooth, press, speed, noise) ==
              approx(expected).epsilon(1e-6));
        CHECK(force(smooth, press, speed, noise) == force(smooth, press, speed, 0));
      }
  // Nearly at rest: a viscosity of no more than sigma3 |w| sqrt(F_n/0.1 mm/s).
  CHECK(force(rough, 4, 1e-9, 1) - force(smooth, 4, 1e-9, 1) ==
        approx(2 * 200 * 1e-9).epsilon(1e-3));
  CHECK(force(rough, 0, 1, 1) == 0);
}

TEST_CASE("what an exciter is told to do changes its velocities against the body by as much") {
  Exciter e;
  e.held = true;
  e.velocity_m_per_s = .5;
  e.approach_m_per_s = .2;
  e.mean_velocity_m_per_s = .1;
  e.move_at(.8);
  CHECK(e.velocity_m_per_s == .8);
  CHECK(e.approach_m_per_s == approx(.5));
  CHECK(e.mean_velocity_m_per_s == approx(.4));
  e.move_at(-1e9); // as fast as anything goes here
  CHECK(e.velocity_m_per_s == -kMaxSpeed);
  Exciter rubbing;
  rubbing.kind = Exciter::Kind::kFriction;
  rubbing.rubbing_m_per_s = -.1;
  rubbing.approach_m_per_s = .2;
  rubbing.mean_velocity_m_per_s = .3;
  rubbing.rub(7, .4);
  CHECK(rubbing.rubbing_m_per_s == .4);
  CHECK(rubbing.normal_force_n == 7);
  CHECK(rubbing.approach_m_per_s == approx(.7));
  CHECK(rubbing.mean_velocity_m_per_s == approx(.8));
  rubbing.rub(1e30, std::nan(""));
  CHECK(rubbing.normal_force_n == kMaxForce);
  CHECK(rubbing.rubbing_m_per_s == 0);
}

TEST_CASE("bristles get steps of .4 rad of their own swing, eight a sample at most") {
  Exciter e;
  e.kind = Exciter::Kind::kFriction;
  FrictionLaw law;
  law.stiffness_n_per_m = 1e6;
  e.friction.set(law);
  for (const double mobility : {1e-3, .1, 10., 200.}) {
    e.impulse_mobility = mobility;
    const double angle = std::sqrt(1e6 * mobility) / kRate;
    CHECK(e.rubbing_steps(1 / kRate) == approx(std::min(angle / .4, 8.)));
  }
  e.impulse_mobility = 1e6;
  CHECK(e.rubbing_steps(1 / kRate) == 8);
}

TEST_CASE("a contact's energy is its striker's and what it stores; a held striker has none") {
  Exciter e;
  CHECK(e.energy() == 0);
  e.kind = Exciter::Kind::kImpact;
  e.mass_kg = .2;
  e.velocity_m_per_s = 3;
  CHECK(e.energy() == approx(.9));
  e.held = true;
  CHECK(e.energy() == 0);
  // Valid from half of the reference energy to a tenth above it.
  e.level_energy_j = 2;
  CHECK(e.level_valid(2));
  CHECK(e.level_valid(2.19));
  CHECK(!e.level_valid(2.21));
  CHECK(e.level_valid(1.01));
  CHECK(!e.level_valid(.99));
}

TEST_CASE("one contact alone takes the force that its own change of velocity leaves it") {
  // F = offset + slope v, v = free - mobility F.
  ContactTerm t;
  t.free = .7;
  t.law = {3, 20};
  t.solve(.05);
  CHECK(t.force == approx(3 + 20 * t.mean));
  CHECK(t.mean == approx(.7 - .05 * t.force));
  t.solve(0);
  CHECK(t.force == approx(17));
  CHECK(extrapolate_velocity(2, 1) == 2.5);
  CHECK(initial_velocity(2, 1) == 1.5);
}

TEST_CASE("quarter powers by roots are those by logarithms, over 300 decades") {
  double worst = 0;
  for (double x = 1e-150; x < 1e150; x *= 1.37)
    for (const double e : {0.0, 0.15, 0.25, 0.5, 0.75, 1.0, 1.25, 0.9})
      worst = std::max(worst, std::abs(Power(e)(x) / std::pow(x, e) - 1));
  CHECK(worst < 1e-15);
}

TEST_CASE("a power that is followed stays within 1e-9 of the exact one, from wherever it begins") {
  for (const double e : {0.0, 0.1, 0.25, 0.65, 1.0, 1.5, 2.5})
    for (const double start : {1e-12, 1e-5, .02, 1., 1.03, 7., 600.}) {
      TaylorPower power(e);
      double worst = 0, x = start;
      for (int n = 0; n < 3000; ++n) {
        worst = std::max(worst, std::abs(power(x) / std::pow(x, e) - 1));
        x *= n < 400 ? (n % 100 < 50 ? 1.003 : .997 / 1.0001) // slowly, and then in leaps
                     : 1 + 0.03 * std::sin(0.37 * n) + (n % 500 == 0 ? 10 : 0) -
                           (n % 777 == 0 ? 0.9 : 0);
        x = std::clamp(x, 1e-50, 1e3);
      }
      CAPTURE(e);
      CAPTURE(start);
      CHECK(worst < 1e-9);
    }
}

// What messages do to a touched body, to the number: impulses, forces, places, modes, and what they
// are held within.
#include "core/contact/excited_body.hpp"
#include "tests/approx.hpp"
#include "tests/core/contact/bodies.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

using namespace tactus::contact;
using tactus::test::approx;
using tactus::test::set_off;

namespace {

constexpr double kRate = 48000, kSixtyDecibels = 6.907755278982137;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity();

/// A block of so many kg that nothing holds.
ExcitedBody block(double mass_kg, std::size_t exciters = 1) {
  ExcitedBody body(1, exciters, 1);
  body.prepare(kRate);
  const Mode rigid{0, 1, mass_kg};
  body.set_modes({&rigid, 1});
  return body;
}

} // namespace

TEST_CASE("an impulse changes a block's velocity by impulse over mass, times the shape at its "
          "contact point") {
  for (const double impulse : {1., -1., .25, 0.}) {
    ExcitedBody body = block(2);
    body.apply_impulse(0, impulse);
    CHECK(body.pickup_velocity() == approx(impulse / 2));
    CHECK(body.energy() == approx(impulse * impulse / 4));
    CHECK(body.active() == (impulse != 0));
    body.step();
    CHECK(body.pickup_velocity() == approx(impulse / 2));
  }
  ExcitedBody body = block(2);
  const double shape = 3;
  body.set_contact_shape(0, {&shape, 1});
  body.apply_impulse(0, 1);
  CHECK(body.pickup_velocity() == approx(1.5));
  body.apply_impulse(1, 1); // there is no such slot
  body.apply_impulse(0, kNan);
  CHECK(body.pickup_velocity() == approx(1.5));
}

TEST_CASE("a force on a mass lasts until it is changed") {
  ExcitedBody body = block(1);
  body.set_impact(0, {}, .5);
  body.launch_mass(0, 1, 0);
  body.set_mass_force(0, -1);
  for (int n = 0; n < 480; ++n)
    body.step();
  CHECK(body.exciter(0).velocity_m_per_s == approx(-2 * 480 / kRate));
  CHECK(body.exciter(0).position_m == approx(-1 - .5 * 2 * 480 * 480 / kRate / kRate));
  body.set_mass_force(0, 0);
  body.step();
  CHECK(body.exciter(0).velocity_m_per_s == approx(-2 * 480 / kRate));
}

TEST_CASE("a mode moves with the velocity that an impulse gives it, decaying as it says") {
  ExcitedBody body(3, 1, 1);
  body.prepare(kRate);
  const std::array<Mode, 3> modes{{{200, .5, .1}, {700, .2, .4}, {30000, 1, 1}}};
  body.set_modes(modes);
  set_off(body, 0, {1, 0});
  CHECK(body.pickup_velocity() == approx(1));
  CHECK(body.energy() == approx(.5 * .1));
  set_off(body, 0, {0, -2});
  CHECK(body.pickup_velocity() == approx(-1));
  CHECK(body.energy() == approx(.5 * .1 + .5 * .4 * 4));
  body.set_contact_shape(0, std::array{0., 0., 1.}); // beyond what can be heard
  body.apply_impulse(0, 5);
  CHECK(body.pickup_velocity() == approx(-1));
  const double before = body.energy();
  for (int n = 0; n < 9600; ++n)
    body.step();
  // m (v^2 + (w^2 + d^2) q^2)/2 falls by 60 dB in its T60, but for ripples of d/w.
  CHECK(body.energy() ==
        approx(.05 * std::exp(-2 * kSixtyDecibels / .5 * .2) + .8 * std::exp(-2 * kSixtyDecibels))
            .epsilon(.03));
  CHECK(body.energy() < before);
}

TEST_CASE("new frequencies, decays, masses and rates leave each mode's two energies alone") {
  ExcitedBody body(2, 1, 1);
  body.prepare(kRate);
  std::array<Mode, 2> modes{{{150, .02, .1}, {460, .5, .3}}};
  body.set_modes(modes);
  set_off(body, 0, {1, .4});
  for (int n = 0; n < 77; ++n)
    body.step();
  const auto kinetic = [&](std::size_t k) {
    const double v =
        body.body().real[k] - body.body().decay_over_omega[k] * body.body().imaginary[k];
    return .5 * v * v;
  };
  const auto elastic = [&](std::size_t k) {
    const double q = body.body().imaginary[k] * body.body().displacement[k],
                 w = 1 / body.body().displacement[k], d = w * body.body().decay_over_omega[k];
    return .5 * (w * w + d * d) * q * q;
  };
  std::array<double, 4> before{};
  const auto energies = [&] { return std::array{kinetic(0), elastic(0), kinetic(1), elastic(1)}; };
  before = energies();
  const auto same = [&] {
    const auto now = energies();
    for (std::size_t i = 0; i < now.size(); ++i) {
      CAPTURE(i);
      CHECK(now[i] == approx(before[i]));
    }
  };
  modes = {{{300, .004, .7}, {90, 3, .01}}};
  body.set_modes(modes);
  same();
  CHECK(1 / body.body().displacement[0] == approx(2 * std::numbers::pi * 300));
  CHECK(body.body().decay_over_omega[0] ==
        approx(kSixtyDecibels / .004 / (2 * std::numbers::pi * 300)));
  body.prepare(96000);
  same();
  CHECK(body.energy() == approx(before[0] + before[1] + before[2] + before[3]));
}

TEST_CASE("numbers of modes and rates are held within their ranges, and nonsense is the usual") {
  ExcitedBody body(4, 1, 1);
  body.prepare(1e8);
  CHECK(body.body().sample_rate() == 1e7);
  body.prepare(1);
  CHECK(body.body().sample_rate() == 1000);
  body.prepare(kNan);
  CHECK(body.body().sample_rate() == 48000);
  const std::array<Mode, 4> modes{
      {{1e-9, 1e9, 1e-30}, {kNan, kInfinity, -kInfinity}, {100, 1e-30, 1e30}, {0, 1, 2}}};
  body.set_modes(modes);
  const auto frequency = [&](std::size_t k) {
    return 1 / (2 * std::numbers::pi * body.body().displacement[k]);
  };
  const auto t60 = [&](std::size_t k) {
    return kSixtyDecibels * body.body().displacement[k] / body.body().decay_over_omega[k];
  };
  const auto mass = [&](std::size_t k) { return std::pow(body.body().inverse_sqrt_mass(k), -2); };
  CHECK(frequency(0) == approx(1e-3));
  CHECK(t60(0) == approx(1e4));
  CHECK(mass(0) == approx(1e-6));
  CHECK(frequency(1) == approx(Mode{}.frequency_hz));
  CHECK(t60(1) == approx(Mode{}.t60_s));
  CHECK(mass(1) == approx(Mode{}.mass_kg));
  CHECK(t60(2) == approx(1e-4));
  CHECK(mass(2) == approx(1e9));
  CHECK(body.body().decay_over_omega[3] == 0);
  CHECK(mass(3) == approx(2));
  // Modes of .49 of the sample rate and above are left out.
  body.set_modes(std::array{Mode{.489 * kRate, 1, 1}, Mode{.4901 * kRate, 1, 1}});
  CHECK(body.body().inverse_sqrt_mass(0) > 0);
  CHECK(body.body().inverse_sqrt_mass(1) == 0);
}

TEST_CASE("a mass moved to another contact point lands as one that was launched there") {
  const std::array<Mode, 2> modes{{{300, 1, .05}, {800, 1, .08}}};
  const std::array<double, 2> first{1, .2}, second{-.7, -1.3};
  const auto play = [&](bool thrown) {
    ExcitedBody body(2, 2, 1); // the other slot keeps this one from being the only one
    body.prepare(kRate);
    body.set_modes(modes);
    body.set_contact_shape(0, first);
    body.set_impact(0, {1e7, 1.5, .1}, .01);
    body.set_impact(1, {1e7, 1.5, .1}, .01);
    body.launch_mass(1, .5, 0);
    body.launch_mass(0, 1.2e-5, .6);
    set_off(body, 1, {0, 1}); // the other mass is far
    body.step();
    CHECK(body.exciter(0).near);
    CHECK(body.force(0) == 0);
    body.set_contact_shape(0, second);
    const Exciter& e = body.exciter(0);
    CHECK(e.depth_m < 0); // it arrives within the next sample
    if (thrown)
      body.launch_mass(0, -e.depth_m, e.velocity_m_per_s);
    std::vector<double> output;
    for (int n = 0; n < 60; ++n) {
      body.step();
      output.push_back(body.pickup_velocity());
      output.push_back(body.force(0));
    }
    CHECK(body.exciter(0).impact_count > 0);
    return output;
  };
  const auto moved = play(false), thrown = play(true);
  for (std::size_t n = 0; n < moved.size(); ++n) {
    CAPTURE(n);
    CHECK(moved[n] == approx(thrown[n]).epsilon(1e-9));
  }
}

TEST_CASE("a pickup has its own shape, and slots out of range change nothing") {
  ExcitedBody body(2, 2, 2);
  body.prepare(kRate);
  const std::array<Mode, 2> modes{{{300, 1, .05}, {800, 1, .08}}};
  body.set_modes(modes);
  const std::array<double, 2> left{1, -2};
  const double only = 3;
  body.set_pickup(0, left);
  body.set_pickup(1, {&only, 1}); // the missing number is 0
  body.set_pickup(2, left);
  set_off(body, 0, {1, .5});
  CHECK(std::abs(body.pickup_velocity(0)) < 1e-12);
  CHECK(body.pickup_velocity(1) == approx(3));
  const double energy = body.energy();
  body.set_contact_shape(2, left);
  body.set_impact(2, {}, 1);
  body.set_friction(2, {});
  body.clear(2);
  body.launch_mass(2, 0, 1);
  body.launch_mass(0, 0, 1); // nothing is in the slot
  body.set_mass_force(2, 1);
  body.rub(2, 1, 1);
  body.seed(2, 1);
  CHECK(body.energy() == energy);
  CHECK(body.exciter(0).kind == Exciter::Kind::kNone);
  CHECK(body.exciter(0).velocity_m_per_s == 0);
}

TEST_CASE("a heavier mass is no faster than its energy, a lighter one keeps its speed") {
  ExcitedBody body = block(1);
  body.set_impact(0, {}, .1);
  body.launch_mass(0, 1, -2);
  body.set_impact(0, {}, .4);
  CHECK(body.exciter(0).velocity_m_per_s == approx(-1));
  CHECK(body.energy() == approx(.5 * .1 * 4));
  body.set_impact(0, {}, .1);
  CHECK(body.exciter(0).velocity_m_per_s == approx(-1));
  CHECK(body.exciter(0).position_m == approx(-1));
  body.set_impact(0, {}, kNan);
  CHECK(body.exciter(0).mass_kg == .01);
  body.set_impact(0, {}, 0);
  CHECK(body.exciter(0).mass_kg == 1e-6);
  body.set_impact(0, {}, 1e9);
  CHECK(body.exciter(0).mass_kg == 1e6);
}

TEST_CASE("after a reset all is at rest, masses are 1 m away, and the sound repeats") {
  const std::array<Mode, 2> modes{{{300, 1, .05}, {800, 1, .08}}};
  ExcitedBody body(2, 3, 1);
  body.prepare(kRate);
  body.set_modes(modes);
  const auto play = [&] {
    body.set_impact(0, {1e7, 1.5, .1}, .01);
    body.launch_mass(0, 1e-5, .6);
    body.set_friction(1, {});
    body.rub(1, 2, .1);
    body.set_impact(2, {1e5, 1, 0}, .1);
    std::vector<double> output;
    for (int n = 0; n < 200; ++n) {
      if (n == 100)
        body.apply_impulse(0, 1e-4);
      body.step();
      output.push_back(body.pickup_velocity());
    }
    return output;
  };
  const auto first = play();
  CHECK(body.exciter(0).impact_count > 0);
  CHECK(body.exciter(1).friction.stored_j() > 0);
  body.reset();
  CHECK(body.energy() == 0);
  CHECK(body.pickup_velocity() == 0);
  CHECK(!body.active());
  for (const std::size_t slot : {0UL, 2UL}) {
    CHECK(body.exciter(slot).position_m == -1);
    CHECK(body.exciter(slot).depth_m == -1);
    CHECK(body.exciter(slot).velocity_m_per_s == 0);
  }
  CHECK(body.exciter(0).impact_count == 0);
  CHECK(body.exciter(0).last.impulse_ns == 0);
  CHECK(body.force(0) == 0);
  CHECK(body.force(1) == 0);
  body.rub(1, 0, 0);
  body.step();
  CHECK(body.pickup_velocity() == 0);
  CHECK(body.steps() == 1);
  body.reset();
  body.seed(1, 2);
  const auto second = play();
  for (std::size_t n = 0; n < first.size(); ++n)
    CHECK(second[n] == approx(first[n]).epsilon(1e-9));
}

TEST_CASE("what moves the body during a contact is felt by it at once, and no energy comes of it") {
  // A mass that lies on a lossless contact and a body without decay worth the name.
  ExcitedBody body(2, 1, 1);
  body.prepare(kRate);
  const std::array<Mode, 2> modes{{{300, 1e4, .05}, {800, 1e4, .08}}};
  body.set_modes(modes);
  body.set_impact(0, {1e6, 1.5, 0}, .05);
  body.launch_mass(0, 0, .4);
  for (int n = 0; n < 5; ++n)
    body.step();
  REQUIRE(body.exciter(0).impact.touching());
  body.apply_impulse(0, .01);
  const double energy = body.energy();
  for (int n = 0; n < 20; ++n) {
    body.step();
    CAPTURE(n);
    CHECK(body.energy() == approx(energy).epsilon(2e-6)); // 1.4e-7 a sample are lost in decay
  }
}

TEST_CASE("a light string gets its bristles' steps, after a reset as well") {
  ExcitedBody body(1, 2, 1);
  body.prepare(kRate);
  const Mode light{300, 1, 1e-3};
  body.set_modes({&light, 1});
  FrictionLaw law;
  law.stiffness_n_per_m = 1e6;
  body.set_friction(0, law);
  // sqrt(1e6/1e-3)/48000 rad a sample, .4 in a step: 1.6, two steps.
  for (int round = 0; round < 2; ++round) {
    body.rub(0, 1, .1);
    body.step();
    CHECK(body.steps() == 2);
    body.reset();
  }
  // What strikes needs its own steps anew: a hard strike, a reset, a soft one.
  body.clear(0);
  for (const double stiffness : {1e11, 1e3}) {
    body.set_impact(1, {stiffness, 1.5, 0}, .01);
    body.launch_mass(1, 0, 1);
    body.step();
    CHECK((body.steps() > 1) == (stiffness > 1e6));
    body.reset();
    body.step();
    CHECK(body.steps() == 1);
  }
}

TEST_CASE(
    "a contact whose phase advances by more than half a radian in 1/64 sample is an impulse") {
  for (const double radians : {.1, .48, .52, 3.}) {
    CAPTURE(radians);
    ExcitedBody body = block(1e9);
    const double rate = radians * 64 * kRate, mass = .01;
    body.set_impact(0, {rate * rate * mass, 1, 0}, mass);
    body.launch_mass(0, 0, 1);
    for (int n = 0; n < 3; ++n)
      body.step();
    REQUIRE(body.exciter(0).impact_count == 1);
    CHECK((body.exciter(0).last.duration_s == 0) == (radians > .5));
    CHECK(body.exciter(0).velocity_m_per_s == approx(-1).epsilon(.01));
    CHECK(body.exciter(0).last.impulse_ns == approx(2 * mass).epsilon(.01));
  }
}

// When a contact of a struck body ends, how finely it is followed, and what is kept of it.
#include "core/contact/excited_body.hpp"
#include "core/modal/contact/contact_solver.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

#include <bit>

using namespace tactus;
using namespace tactus::modal;
using namespace tactus::test;

namespace {

int samples_until_end(ContactSolver& solver, int maximum) {
  int n = 0;
  for (; n < maximum && solver.touching(); ++n)
    static_cast<void>(solver.step());
  return n;
}

void run(ContactSolver& solver, int samples) {
  for (int n = 0; n < samples; ++n)
    static_cast<void>(solver.step());
}

ContactSolver::Strike flying(double height, double velocity) {
  ContactSolver::Strike strike;
  strike.position_m = -height;
  strike.velocity_m_per_s = velocity;
  return strike;
}

ContactSolver::Strike pressing(double stiffness, double mass_kg, double velocity) {
  ContactSolver::Strike strike = flying(0, velocity);
  strike.law = {stiffness, 1, 0};
  strike.mass_kg = mass_kg;
  return strike;
}

ContactSolver::Strike hand() {
  ContactSolver::Strike strike;
  strike.law = {1e6, 1, 0};
  strike.held = true;
  return strike;
}

/// Twelve modes, their gains at a point.
struct Body {
  Body() {
    for (int k = 0; k < 12; ++k) {
      const double t60 = 0.3 + 0.1 * k, mass = 0.02 + 0.003 * k;
      modes.push_back({230 + 411.0 * k, t60, mass});
      rate.emplace_back(-std::log(1000.) / t60, 2 * kPi * modes.back().frequency_hz);
      shape.push_back(std::cos(0.7 + 1.3 * k));
      gain.push_back(shape.back() / std::sqrt(mass));
    }
  }
  std::vector<contact::Mode> modes;
  std::vector<Complex> rate;
  std::vector<double> shape, gain;
};

} // namespace

TEST_CASE("a striker above a mode is followed until the decaying mode can no longer reach it") {
  // 1.2 mm to and fro, a striker almost still 1 mm above: the first half turn goes inwards, and
  // when the surface comes back it is far too quiet. |z| is known within 8 %, every 64 samples.
  const Complex rate(-100, 2 * kPi * 50);
  const double gain = 1;
  ContactSolver solver({&rate, 1}, kRate, 1, false);
  solver.set_state(0, rate.imag() * 1.2e-3);
  solver.begin(0, flying(1e-3, -1e-9), {&gain, 1}, {});
  const double minimum = std::log(1.2) / 100, maximum = std::log(1.2 * 1.08) / 100;
  const int end = samples_until_end(solver, 4800);
  CHECK(end > minimum * kRate);
  CHECK(end < maximum * kRate + 64 + 2);
  // One that leaves faster than the surface ever moves is gone at once.
  solver.begin(0, flying(1e-6, -1.2 * 1.08 * 1.2e-3 * rate.imag()), {&gain, 1}, {});
  CHECK(samples_until_end(solver, 4800) == 1);
}

TEST_CASE("a striker that a free body moves after is followed until the body cannot catch up") {
  // No modes: a block with the velocity that a first striker has given it, a second one before it.
  const std::array<double, 6> gain{3, 0, 0, 0, 0, 0};
  const auto follow = [&](double velocity) {
    ContactSolver solver({}, kRate, 2, true);
    solver.begin(0, pressing(1e8, .01, 1), {}, gain);
    solver.begin(1, flying(.5, velocity), {}, gain); // .5 m away: never met within the test
    run(solver, 200);
    CHECK(!solver.contact(0).active);
    return solver.contact(1).active;
  };
  // The block gets 2 m/(m + M) of the speed: m = 10 g, M = 1/9 kg.
  const double block = 2 * .01 / (.01 + 1 / 9.);
  CHECK(follow(1.02 * block) == true); // the body moves inwards: away from what is slower
  CHECK(follow(.98 * block) == false);
}

TEST_CASE("a striker in flight is followed for at most 50 ms") {
  // Many modes that never decay reach further than it is away, and do not come there.
  std::vector<Complex> rate;
  std::vector<double> gain;
  for (int k = 0; k < 40; ++k) {
    rate.emplace_back(-1e-6, 2 * kPi * (3000. + 711 * k + 17. * k * k));
    gain.push_back(1);
  }
  ContactSolver solver(rate, kRate, 1, false);
  for (std::size_t k = 0; k < rate.size(); ++k)
    solver.set_state(k, {0, 2e-4 * rate[k].imag() * (k % 2 ? -1 : 1) / 8});
  solver.begin(0, flying(5e-4, -1e-4), gain, {});
  CHECK(std::abs(samples_until_end(solver, 9600) - .05 * kRate) < 3);
  CHECK(solver.contact(0).exciter.impact_count == 0);
}

TEST_CASE(
    "a striker out of reach costs one step a sample; a force on the body restores the steps") {
  const Complex rate(-1, 2 * kPi * 5);
  const double gain = 4;
  const float push = 4;
  ContactSolver solver({&rate, 1}, kRate, 1, false);
  solver.begin(0, flying(1e-3, .05), {&gain, 1}, {}); // 20 ms away
  run(solver, 10);
  CHECK(solver.steps() == 1);
  CHECK(solver.touching());
  solver.apply_impulse({&push, 1}, -1.25); // 20 m/s outwards: there in the third sample
  run(solver, 2);
  CHECK(solver.contact(0).exciter.force_n == 0);
  CHECK(solver.steps() >= 4);
  run(solver, 1);
  CHECK(solver.contact(0).exciter.force_n > 0);
  // One that is so near that it may arrive within two samples is followed as a contact is.
  solver.begin(0, flying(.05 / kRate, .05), {&gain, 1}, {});
  run(solver, 1);
  CHECK(solver.steps() >= 4);
  // And a contact that begins anew, after one that was out of reach.
  ContactSolver other({}, kRate, 1, false);
  other.begin(0, flying(1e-2, .05), {}, {});
  run(other, 3);
  CHECK(other.steps() == 1);
  other.begin(0, flying(0, .05), {}, {});
  run(other, 1);
  CHECK(other.steps() >= 4);
}

TEST_CASE("a striker under gravity has settled after eight contact durations, without it never") {
  const auto lie = [](double velocity, double retuned_s) {
    ContactSolver::Strike strike = pressing(1000, 1, velocity);
    strike.law.dissipation_s_per_m = 100;
    strike.fall_m_per_s2 = 9.80665;
    ContactSolver solver({}, kRate, 1, false);
    solver.begin(0, strike, {}, {});
    double time = 0;
    bool replaced = false;
    for (; time < 3 && solver.touching(); time += 1 / kRate) {
      static_cast<void>(solver.step());
      if (!replaced && retuned_s > 0 && time > retuned_s) {
        ContactSolver next({}, kRate, 1, false);
        next.take_over(0, solver, 0, {}, {});
        CHECK(next.touching());
        solver = std::move(next);
        replaced = true;
      }
    }
    CHECK(solver.contact(0).settled);
    return time;
  };
  const double contact = kPi * std::sqrt(1. / 1000);
  CHECK(lie(1, 0) == approx(8 * contact).epsilon(1e-3));
  // A contact that goes on with another solver has not waited in vain.
  CHECK(lie(1, .3) == approx(8 * contact).epsilon(1e-3));
  // One that was laid down is given the time of the longest flight.
  CHECK(lie(0, 0) == approx(.05).epsilon(1e-3));
  // Half a period of .7 s, however long it presses.
  ContactSolver solver({}, kRate, 1, false);
  solver.begin(0, pressing(20, 1, 1e-3), {}, {});
  CHECK(samples_until_end(solver, 96000) / kRate == approx(kPi * std::sqrt(1 / 20.)).epsilon(.01));
  CHECK(!solver.contact(0).settled);
}

TEST_CASE("steps follow the contact's angular frequency, and a sample's work is bounded") {
  const auto steps = [](std::size_t modes, std::size_t contacts, double stiffness) {
    std::vector<Complex> rate;
    for (std::size_t k = 0; k < modes; ++k)
      rate.emplace_back(-1, 2 * kPi * (100. + static_cast<double>(k)));
    const std::vector<double> gain(modes, 0);
    ContactSolver solver(rate, kRate, contacts, false);
    for (std::size_t i = 0; i < contacts; ++i)
      solver.begin(i, pressing(stiffness, .01, 1), gain, {});
    run(solver, 1);
    return solver.steps();
  };
  // sqrt(k/m) h <= 0.15 rad, next power of 2.
  for (const double stiffness : {1e7, 3e7, 1e8, 1e9, 4e9}) {
    CAPTURE(stiffness);
    const double wanted = std::sqrt(stiffness / .01) / .15 / kRate;
    CHECK(steps(0, 1, stiffness) == std::bit_ceil(static_cast<unsigned>(std::ceil(wanted))));
  }
  struct Case {
    std::size_t modes, contacts, steps;
  };
  for (const Case& c : {Case{0, 1, 1024},
                        {16, 1, 1024},
                        {64, 1, 256},
                        {4096, 1, 4},
                        {10000, 1, 2}, // never below two
                        {0, 2, 512},
                        {0, 3, 256},
                        {0, 16, 64}}) {
    CAPTURE(c.modes);
    CAPTURE(c.contacts);
    CHECK(steps(c.modes, c.contacts, 1e14) == c.steps);
  }
  CHECK(steps(0, 1, 1e3) == 4); // a slow one in 176 400 a second at least
}

TEST_CASE("steps grow coarse again when the contact that needed them is over") {
  ContactSolver solver({}, kRate, 2, false);
  ContactSolver::Strike hard = flying(0, 1);
  hard.law = {1e10, 1.5, 0};
  solver.begin(1, pressing(1e3, .01, .01), {}, {});
  run(solver, 1);
  CHECK(solver.steps() == 4);
  solver.begin(0, hard, {}, {});
  run(solver, 1);
  CHECK(solver.steps() >= 16);
  while (solver.contact(0).active)
    run(solver, 1);
  run(solver, 1);
  CHECK(solver.steps() == 4);
  CHECK(solver.active() == 1);
}

TEST_CASE("a held striker reaches its target within the sample, within its speed limit") {
  ContactSolver solver({}, kRate, 1, false);
  const auto depth = [&] { return solver.contact(0).exciter.position_m; };
  solver.begin(0, hand(), {}, {});
  solver.set_held_position(0, 1e-5);
  CHECK(solver.step() > 0);
  CHECK(depth() == approx(1e-5));
  solver.set_held_position(0, 1); // a metre
  run(solver, 1);
  CHECK(depth() == approx(1e-5 + 50 / kRate));
  solver.set_held_position(0, -1, 10);
  run(solver, 1);
  CHECK(depth() == approx(1e-5 + 40 / kRate));
  // A spring's law at that depth, in the mean of a sample that stands still.
  solver.set_held_position(0, depth());
  CHECK(solver.step() == approx(1e6 * depth()).epsilon(1e-9));
  // It stays as long as it likes away from the surface.
  for (int n = 0; n < 4800; ++n) {
    solver.set_held_position(0, -1e-2);
    run(solver, 1);
  }
  CHECK(solver.touching());
  CHECK(depth() == approx(-1e-2));
  solver.end(0);
  CHECK(!solver.touching());
  CHECK(solver.contact(0).exciter.force_n == 0);
  // It begins without stored energy where it is inside already, and takes few steps if hard.
  ContactSolver::Strike inside = hand();
  inside.position_m = 1e-3;
  inside.law.stiffness = 1e14;
  solver.begin(0, inside, {}, {});
  CHECK(solver.contact(0).exciter.depth_m == 0);
  CHECK(solver.energy() == 0);
  run(solver, 2);
  CHECK(solver.steps() == 4);
}

TEST_CASE("the moments of a sample's force are those of its steps over Legendre's polynomials") {
  // A hand that presses a stiff spring into a rigid wall, in four steps a sample.
  ContactSolver solver({}, kRate, 1, false);
  ContactSolver::Strike spring = hand();
  spring.law.stiffness = 1e12;
  solver.begin(0, spring, {}, {});
  const auto moments = [&](double depth) {
    solver.set_held_position(0, depth);
    run(solver, 1);
    REQUIRE(solver.steps() == 4);
    REQUIRE(solver.sampled().size() == 1);
    CHECK(solver.sampled()[0].moments[0] ==
          approx(solver.contact(0).exciter.force_n).epsilon(1e-12));
    return solver.sampled()[0].moments;
  };
  static_cast<void>(moments(1e-9));
  // Still: nothing but the mean, 1000 N.
  const auto still = moments(1e-9);
  CHECK(still[0] == approx(1000).epsilon(1e-6));
  CHECK(std::abs(still[1]) < 1e-3);
  CHECK(std::abs(still[2]) < 1e-3);
  // From 1000 to 2000 N in a line, x from 1 to -1 over the sample: the sum of x^2 over the middles
  // of n steps is n (1 - 1/n^2)/3.
  const auto ramp = moments(2e-9);
  CHECK(ramp[0] == approx(1500).epsilon(1e-6));
  CHECK(ramp[1] == approx(-500 * (1 - 1 / 16.) / 3).epsilon(1e-6));
  CHECK(std::abs(ramp[2]) < 1e-3);
  solver.silence();
  // A hand at constant speed into F = k d^2: within a sample F = A + B x + C x^2, C = k (v/2)^2.
  // Over four steps the means of x^2 are x_j^2 + 1/48, those of the polynomial 1.5 of it - 1/2.
  ContactSolver::Strike pin = hand();
  pin.law = {1e15, 2, 0};
  solver.begin(0, pin, {}, {});
  double depth = 0;
  constexpr double kStepDepth = 4e-6;
  for (int n = 0; n < 6; ++n) {
    solver.set_held_position(0, depth += kStepDepth);
    run(solver, 1);
  }
  REQUIRE(solver.steps() == 4);
  const double bend = 1e15 * kStepDepth * kStepDepth / 4, part = 1. / 48;
  const double inner = 1. / 16 + part, outer = 9. / 16 + part;
  const double expected = bend * (inner * (1.5 * inner - .5) + outer * (1.5 * outer - .5)) / 2;
  CHECK(solver.sampled()[0].moments[2] == approx(expected).epsilon(.02));
  // And the first: B x with B = k d v at the middle, x from 1 to -1 in the sample.
  const double slope = 1e15 * kStepDepth * (depth - kStepDepth / 2);
  CHECK(solver.sampled()[0].moments[1] == approx(-slope * (1. / 16 + 9. / 16) / 2).epsilon(.01));
}

TEST_CASE("energy is that of the motion, the recoil, the strikers, their height and the contacts") {
  const std::vector<Complex> rate{{-40, 2 * kPi * 200}, {-300, 2 * kPi * 130}};
  ContactSolver solver(rate, kRate, 2, true);
  // Displacement and velocity of each mode, mass-normalised.
  const double q[2] = {2e-4, -3e-4}, v[2] = {-.3, .5};
  double energy = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    solver.set_state(k, {v[k] - rate[k].real() * q[k], rate[k].imag() * q[k]});
    energy += .5 * (v[k] * v[k] + norm(rate[k]) * q[k] * q[k]);
  }
  CHECK(solver.energy() == approx(energy).epsilon(1e-12));
  // What is far above a body without gain is a stone that falls: its energy stays.
  ContactSolver still({}, kRate, 1, true);
  ContactSolver::Strike stone = flying(.5, 1);
  stone.mass_kg = 2;
  stone.fall_m_per_s2 = 9.80665;
  still.begin(0, stone, {}, {});
  run(still, 1000);
  CHECK(still.energy() == approx(.5 * 2 * 1 + 2 * 9.80665 * .5).epsilon(1e-9));
  // And through the strike, on a body that takes its part without loss.
  stone.position_m = 0;
  stone.law = {1e8, 1.5, 0};
  const std::vector<Complex> lossless{{0, 2 * kPi * 900}};
  const double gain = 2;
  ContactSolver body(lossless, kRate, 1, true);
  body.begin(0, stone, {&gain, 1}, {1, 0, .5, 0, 0, .2});
  for (int n = 0; n < 40; ++n) {
    run(body, 1);
    CAPTURE(n);
    CHECK(body.energy() == approx(1).epsilon(1e-9));
  }
  CHECK(body.contact(0).exciter.force_n > 0);
}

TEST_CASE("a free body whose size and mass change goes on moving as it was") {
  // Along r and turning: a gain of 1/sqrt(m) and one of arm/sqrt(I).
  const double longer = 1.5, heavier = 2;
  const std::array<double, 6> gain{0, 2, 0, 0, 3, 0};
  std::array<double, 6> changed{};
  for (std::size_t r = 0; r < 6; ++r) // I grows with m L^2, the arm with L: they cancel
    changed[r] = gain[r] / std::sqrt(heavier);
  ContactSolver before({}, kRate, 1, true), after({}, kRate, 1, true);
  before.begin(0, pressing(1e4, .01, 1), {}, gain); // a contact of milliseconds
  double moved = 0, turned = 0, impulse = 0;
  for (int n = 0; n < 60; ++n) {
    run(before, 1);
    const double gone = (impulse + .5 * before.contact(0).exciter.impulse_ns) / kRate;
    moved += 4 * gone;
    turned += 9 * gone;
    impulse += before.contact(0).exciter.impulse_ns;
  }
  REQUIRE(before.contact(0).active);
  after.take_over_rigid(before, heavier, longer);
  after.take_over(0, before, 0, {}, changed);
  const contact::Exciter& e = after.contact(0).exciter;
  // The place has moved as far, and has turned as far at a longer arm.
  CHECK(e.position_m - e.depth_m == approx(moved + longer * turned).epsilon(1e-3));
  // Energy of the recoil: m v^2 and I w^2.
  const double striker = e.energy(), other = before.contact(0).exciter.energy();
  const double translation = .5 * 4 * impulse * impulse, rotation = .5 * 9 * impulse * impulse;
  CHECK(before.energy() - other == approx(translation + rotation).epsilon(1e-6));
  CHECK(after.energy() - striker ==
        approx(heavier * (translation + longer * longer * rotation)).epsilon(1e-6));
}

TEST_CASE("a free body that nothing touches is at rest for the next strike") {
  const std::array<double, 6> gain{3, 0, 0, 0, 0, 0};
  ContactSolver solver({}, kRate, 1, true);
  const ContactSolver::Strike strike = flying(0, 1);
  solver.begin(0, strike, {}, gain);
  static_cast<void>(samples_until_end(solver, 4800));
  REQUIRE(!solver.touching());
  solver.begin(0, strike, {}, gain);
  run(solver, 1);
  CHECK(solver.energy() == approx(0.5 * strike.mass_kg).epsilon(1e-9));
}

TEST_CASE("friction on a struck body has the force that core/contact computes") {
  const Body body;
  contact::FrictionLaw law;
  law.stiffness_n_per_m = 3e5;
  contact::ExcitedBody excited(body.modes.size(), 1, 1);
  excited.prepare(kRate);
  excited.set_modes(body.modes);
  excited.set_contact_shape(0, body.shape);
  excited.set_friction(0, law);
  ContactSolver solver(body.rate, kRate, 1, false);
  solver.begin_rub(0, law, body.gain, {});
  for (int n = 0; n < 400; ++n) {
    const double press = 1 + 0.5 * std::sin(0.01 * n), speed = 0.2 * std::sin(0.02 * n);
    excited.rub(0, press, speed);
    excited.step();
    solver.rub(0, press, speed);
    CHECK(solver.step() == 0); // nothing presses inwards
    CAPTURE(n);
    REQUIRE(solver.steps() == excited.steps());
    REQUIRE(solver.contact(0).exciter.force_n == approx(excited.force(0)).epsilon(1e-7));
  }
}

TEST_CASE("two rough surfaces on one body have different noise") {
  const Body body;
  ContactSolver solver(body.rate, kRate, 2, false);
  contact::FrictionLaw law;
  law.roughness = 1;
  for (std::size_t i = 0; i < 2; ++i)
    solver.begin_rub(i, law, body.gain, {});
  double difference = 0;
  for (int n = 0; n < 100; ++n) {
    for (std::size_t i = 0; i < 2; ++i)
      solver.rub(i, 1, 0.5);
    run(solver, 1);
    difference += std::abs(solver.contact(0).exciter.force_n - solver.contact(1).exciter.force_n);
  }
  CHECK(difference > 1e-3);
}

TEST_CASE("calls for missing slots and ended contacts change nothing") {
  const double gain = 1;
  const Complex rate(-1, 2 * kPi * 100);
  ContactSolver solver({&rate, 1}, kRate, 2, true);
  const auto call = [&] {
    for (const std::size_t slot : {0UL, 2UL}) {
      solver.set_held_position(slot, 1);
      solver.rub(slot, 1, 1);
      solver.set_friction(slot, {});
      solver.move_rub(slot, {&gain, 1}, {});
      solver.end(slot);
    }
    solver.begin(2, flying(0, 1), {&gain, 1}, {});
    solver.begin_rub(2, {}, {&gain, 1}, {});
    solver.take_over(2, solver, 0, {&gain, 1}, {});
    solver.take_over(0, solver, 2, {&gain, 1}, {});
  };
  const auto check_rest = [&] {
    CHECK(!solver.touching());
    CHECK(solver.step() == 0);
    CHECK(solver.sampled().empty());
    CHECK(solver.state(0) == Complex(0));
  };
  call();
  check_rest();
  solver.begin(1, flying(0, 1), {&gain, 1}, {});
  call();
  CHECK(solver.active() == 1);
  CHECK(solver.step() > 0);
  REQUIRE(solver.sampled().size() == 1);
  CHECK(solver.sampled()[0].slot == 1);
  solver.silence();
  check_rest();
}

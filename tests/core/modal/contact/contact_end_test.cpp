// When a contact of a struck body ends, how finely it is followed, and what is kept of it.
#include "core/modal/contact/contact_solver.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

using namespace tactus;
using modal::ContactSolver;
using Complex = std::complex<double>;
using tactus::test::approx;

namespace {

constexpr double kRate = 48000, kPi = std::numbers::pi;

int samples_until_end(ContactSolver& solver, int maximum) {
  int n = 0;
  for (; n < maximum && solver.touching(); ++n)
    static_cast<void>(solver.step());
  return n;
}

ContactSolver::Strike flying(double height, double velocity) {
  ContactSolver::Strike strike;
  strike.position_m = -height;
  strike.velocity_m_per_s = velocity;
  return strike;
}

ContactSolver::Strike hand() {
  ContactSolver::Strike strike;
  strike.law = {1e6, 1, 0};
  strike.held = true;
  return strike;
}

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
    ContactSolver::Strike first = flying(0, 1);
    first.law = {1e8, 1, 0};
    solver.begin(0, first, {}, gain);
    solver.begin(1, flying(.5, velocity), {}, gain); // .5 m away: never met within the test
    for (int n = 0; n < 200; ++n)
      static_cast<void>(solver.step());
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
  for (int n = 0; n < 10; ++n)
    static_cast<void>(solver.step());
  CHECK(solver.steps() == 1);
  CHECK(solver.touching());
  solver.apply_impulse({&push, 1}, -1.25); // 20 m/s outwards: there in the third sample
  static_cast<void>(solver.step());
  static_cast<void>(solver.step());
  CHECK(solver.contact(0).exciter.force_n == 0);
  CHECK(solver.steps() >= 4);
  static_cast<void>(solver.step());
  CHECK(solver.contact(0).exciter.force_n > 0);
  // One that is so near that it may arrive within two samples is followed as a contact is.
  solver.begin(0, flying(.05 / kRate, .05), {&gain, 1}, {});
  static_cast<void>(solver.step());
  CHECK(solver.steps() >= 4);
  // And a contact that begins anew, after one that was out of reach.
  ContactSolver other({}, kRate, 1, false);
  other.begin(0, flying(1e-2, .05), {}, {});
  for (int n = 0; n < 3; ++n)
    static_cast<void>(other.step());
  CHECK(other.steps() == 1);
  other.begin(0, flying(0, .05), {}, {});
  static_cast<void>(other.step());
  CHECK(other.steps() >= 4);
}

TEST_CASE("a striker under gravity has settled after eight contact durations") {
  const auto lie = [](double velocity, double retuned_s) {
    ContactSolver::Strike strike;
    strike.law = {1000, 1, 0};
    strike.law.dissipation_s_per_m = 100;
    strike.mass_kg = 1;
    strike.velocity_m_per_s = velocity;
    strike.fall_m_per_s2 = 9.80665;
    const auto make = [] { return ContactSolver({}, kRate, 1, false); };
    ContactSolver solver = make();
    solver.begin(0, strike, {}, {});
    double time = 0;
    bool replaced = false;
    for (; time < 3 && solver.touching(); time += 1 / kRate) {
      static_cast<void>(solver.step());
      if (!replaced && retuned_s > 0 && time > retuned_s) {
        ContactSolver next = make();
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
}

TEST_CASE("without gravity no striker settles, however long it presses") {
  ContactSolver::Strike strike;
  strike.law = {20, 1, 0}; // half a period of .7 s
  strike.mass_kg = 1;
  strike.velocity_m_per_s = 1e-3;
  ContactSolver solver({}, kRate, 1, false);
  solver.begin(0, strike, {}, {});
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
    ContactSolver::Strike strike;
    strike.law = {stiffness, 1, 0};
    strike.mass_kg = .01;
    strike.velocity_m_per_s = 1;
    for (std::size_t i = 0; i < contacts; ++i)
      solver.begin(i, strike, gain, {});
    static_cast<void>(solver.step());
    return solver.steps();
  };
  // sqrt(k/m) h <= 0.15 rad, next power of 2.
  for (const double stiffness : {1e7, 3e7, 1e8, 1e9, 4e9}) {
    CAPTURE(stiffness);
    const double wanted = std::sqrt(stiffness / .01) / .15 / kRate;
    CHECK(steps(0, 1, stiffness) == std::bit_ceil(static_cast<unsigned>(std::ceil(wanted))));
  }
  CHECK(steps(0, 1, 1e14) == 1024);
  CHECK(steps(16, 1, 1e14) == 1024);
  CHECK(steps(64, 1, 1e14) == 256);
  CHECK(steps(4096, 1, 1e14) == 4);
  CHECK(steps(10000, 1, 1e14) == 2);
  CHECK(steps(0, 2, 1e14) == 512);
  CHECK(steps(0, 3, 1e14) == 256);
  CHECK(steps(0, 16, 1e14) == 64);
  CHECK(steps(0, 700, 1e14) == 2); // never below two
}

TEST_CASE("steps grow coarse again when the contact that needed them is over") {
  ContactSolver solver({}, kRate, 2, false);
  ContactSolver::Strike hard = flying(0, 1), soft = flying(0, .01);
  hard.law = {1e10, 1.5, 0};
  soft.law = {1e3, 1, 0};
  solver.begin(1, soft, {}, {});
  static_cast<void>(solver.step());
  CHECK(solver.steps() == 4);
  solver.begin(0, hard, {}, {});
  static_cast<void>(solver.step());
  CHECK(solver.steps() >= 16);
  while (solver.contact(0).active)
    static_cast<void>(solver.step());
  static_cast<void>(solver.step());
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
  static_cast<void>(solver.step());
  CHECK(depth() == approx(1e-5 + 50 / kRate));
  solver.set_held_position(0, -1, 10);
  static_cast<void>(solver.step());
  CHECK(depth() == approx(1e-5 + 40 / kRate));
  // A spring's law at that depth, in the mean of a sample that stands still.
  solver.set_held_position(0, depth());
  CHECK(solver.step() == approx(1e6 * depth()).epsilon(1e-9));
  // It stays as long as it likes away from the surface.
  for (int n = 0; n < 4800; ++n) {
    solver.set_held_position(0, -1e-2);
    static_cast<void>(solver.step());
  }
  CHECK(solver.touching());
  CHECK(depth() == approx(-1e-2));
  solver.end(0);
  CHECK(!solver.touching());
  CHECK(solver.contact(0).exciter.force_n == 0);
}

TEST_CASE("the second moment of a sample's force is that of its curvature") {
  // A hand at constant speed into F = k d^2: within a sample F = A + B x + C x^2, C = k (v/2)^2.
  // Over four steps the means of x^2 are x_j^2 + 1/48, those of the polynomial 1.5 of it - 1/2.
  ContactSolver solver({}, kRate, 1, false);
  ContactSolver::Strike pin = hand();
  pin.law = {1e15, 2, 0};
  solver.begin(0, pin, {}, {});
  double depth = 0;
  constexpr double kStepDepth = 4e-6;
  for (int n = 0; n < 6; ++n) {
    solver.set_held_position(0, depth += kStepDepth);
    static_cast<void>(solver.step());
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
    energy += .5 * (v[k] * v[k] + std::norm(rate[k]) * q[k] * q[k]);
  }
  CHECK(solver.energy() == approx(energy).epsilon(1e-12));
  // What is far above a body without gain is a stone that falls: its energy stays.
  ContactSolver still({}, kRate, 1, true);
  ContactSolver::Strike stone = flying(.5, 1);
  stone.mass_kg = 2;
  stone.fall_m_per_s2 = 9.80665;
  still.begin(0, stone, {}, {});
  for (int n = 0; n < 1000; ++n)
    static_cast<void>(still.step());
  CHECK(still.energy() == approx(.5 * 2 * 1 + 2 * 9.80665 * .5).epsilon(1e-9));
  // And through the strike, on a body that takes its part without loss.
  stone.position_m = 0;
  stone.law = {1e8, 1.5, 0};
  const std::vector<Complex> lossless{{0, 2 * kPi * 900}};
  const double gain = 2;
  ContactSolver body(lossless, kRate, 1, true);
  body.begin(0, stone, {&gain, 1}, {1, 0, .5, 0, 0, .2});
  for (int n = 0; n < 40; ++n) {
    static_cast<void>(body.step());
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
  ContactSolver::Strike strike = flying(0, 1);
  strike.law = {1e4, 1, 0}; // a contact of milliseconds
  before.begin(0, strike, {}, gain);
  double moved = 0, turned = 0, impulse = 0;
  for (int n = 0; n < 60; ++n) {
    static_cast<void>(before.step());
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

TEST_CASE("calls for missing slots and ended contacts change nothing") {
  const double gain = 1;
  const Complex rate(-1, 2 * kPi * 100);
  ContactSolver solver({&rate, 1}, kRate, 2, true);
  const auto calls = [&](std::size_t slot) {
    solver.set_held_position(slot, 1);
    solver.rub(slot, 1, 1);
    solver.set_friction(slot, {});
    solver.move_rub(slot, {&gain, 1}, {});
    solver.end(slot);
  };
  solver.begin(2, flying(0, 1), {&gain, 1}, {});
  solver.begin_rub(2, {}, {&gain, 1}, {});
  solver.take_over(2, solver, 0, {&gain, 1}, {});
  solver.take_over(0, solver, 2, {&gain, 1}, {});
  calls(2);
  calls(0);
  CHECK(!solver.touching());
  CHECK(solver.step() == 0);
  CHECK(solver.sampled().empty());
  CHECK(solver.energy() == 0);
  solver.begin(1, flying(0, 1), {&gain, 1}, {});
  calls(0);
  calls(2);
  CHECK(solver.active() == 1);
  CHECK(solver.step() > 0);
  REQUIRE(solver.sampled().size() == 1);
  CHECK(solver.sampled()[0].slot == 1);
  solver.silence();
  CHECK(!solver.touching());
  CHECK(solver.state(0) == Complex(0));
  CHECK(solver.step() == 0);
  CHECK(solver.sampled().empty());
}

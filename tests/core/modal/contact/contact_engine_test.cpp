// A struck body's contacts are those of core/contact: the same forces, sample by sample, and what
// ContactSolver adds to them.
#include "core/contact/excited_body.hpp"
#include "core/modal/contact/contact_solver.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

using namespace tactus;
using modal::ContactSolver;
using Complex = std::complex<double>;
using tactus::test::approx;

namespace {

constexpr double kRate = 48000, kPi = std::numbers::pi, kSixtyDecibels = 6.907755278982137;

/// The same twelve modes for both.
struct Body {
  Body() {
    for (int k = 0; k < 12; ++k) {
      const double hz = 230 + 411.0 * k, t60 = 0.3 + 0.1 * k, mass = 0.02 + 0.003 * k;
      modes.push_back({hz, t60, mass});
      rate.emplace_back(-kSixtyDecibels / t60, 2 * kPi * hz);
      for (std::size_t index = 0; index < 2; ++index) {
        const double shape = std::cos(0.7 + static_cast<double>(index) + 1.3 * k);
        shapes[index].push_back(shape);
        gain[index].push_back(shape / std::sqrt(mass));
      }
    }
  }
  std::vector<contact::Mode> modes;
  std::vector<Complex> rate;
  std::vector<double> shapes[2], gain[2];
};

} // namespace

TEST_CASE("friction on a struck body has the force that core/contact computes") {
  const Body body;
  contact::FrictionLaw law;
  law.stiffness_n_per_m = 3e5;
  contact::ExcitedBody excited(body.modes.size(), 1, 1);
  excited.prepare(kRate);
  excited.set_modes(body.modes);
  excited.set_contact_shape(0, body.shapes[0]);
  excited.set_friction(0, law);
  ContactSolver solver(body.rate, kRate, 1, false);
  solver.begin_rub(0, law, body.gain[0], {});
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

TEST_CASE("two strikers on a struck body have the forces that core/contact computes") {
  const Body body;
  contact::ExcitedBody excited(body.modes.size(), 2, 1);
  excited.prepare(kRate);
  excited.set_modes(body.modes);
  excited.set_min_steps(64);
  ContactSolver solver(body.rate, kRate, 2, false);
  const double speed[2] = {0.7, 1.1};
  for (std::size_t i = 0; i < 2; ++i) {
    // So stiff that both engines take 64 steps: 0.15 rad in each at the deepest.
    const contact::ImpactLaw law{2e10, 1.5, 0.2};
    excited.set_contact_shape(i, body.shapes[i]);
    excited.set_impact(i, law, 0.01);
    excited.launch_mass(i, 0, speed[i]);
    ContactSolver::Strike strike;
    strike.law = law;
    strike.mass_kg = 0.01;
    strike.velocity_m_per_s = speed[i];
    solver.begin(i, strike, body.gain[i], {});
  }
  double impulse = 0;
  for (int n = 0; n < 12; ++n) {
    excited.step();
    static_cast<void>(solver.step());
    for (std::size_t i = 0; i < 2; ++i) {
      CAPTURE(n);
      CAPTURE(i);
      CHECK(std::abs(solver.contact(i).exciter.force_n - excited.force(i)) < 2);
      impulse += excited.force(i) / kRate;
    }
  }
  CHECK(impulse * kRate > 400); // against a difference of 2 N
}

TEST_CASE(
    "a strike is followed in 176 400 steps a second at least, a hand in four a sample at most") {
  ContactSolver solver({}, kRate, 1, false);
  ContactSolver::Strike strike;
  strike.law = {1e3, 1, 0}; // a contact of ten milliseconds
  strike.velocity_m_per_s = 0.1;
  solver.begin(0, strike, {}, {});
  static_cast<void>(solver.step());
  CHECK(solver.steps() == 4);
  strike.held = true;
  strike.law.stiffness = 1e14;
  solver.begin(0, strike, {}, {});
  solver.set_held_position(0, 1e-9);
  static_cast<void>(solver.step());
  static_cast<void>(solver.step());
  CHECK(solver.steps() == 4);
}

TEST_CASE("no contact begins with stored energy, wherever the hand is") {
  ContactSolver solver({}, kRate, 1, false);
  ContactSolver::Strike hand;
  hand.held = true;
  hand.position_m = 1e-3; // inside already
  solver.begin(0, hand, {}, {});
  CHECK(solver.contact(0).exciter.depth_m == 0);
  CHECK(solver.energy() == 0);
}

TEST_CASE("a free body that nothing touches is at rest for the next strike") {
  const std::array<double, 6> gain{3, 0, 0, 0, 0, 0};
  ContactSolver solver({}, kRate, 1, true);
  ContactSolver::Strike strike;
  strike.velocity_m_per_s = 1;
  solver.begin(0, strike, {}, gain);
  for (int n = 0; n < 4800 && solver.touching(); ++n)
    static_cast<void>(solver.step());
  REQUIRE(!solver.touching());
  solver.begin(0, strike, {}, gain);
  static_cast<void>(solver.step());
  CHECK(solver.energy() == approx(0.5 * strike.mass_kg).epsilon(1e-9));
}

TEST_CASE("a contact that continues with other mode shapes keeps its compression") {
  const Body body;
  ContactSolver before(body.rate, kRate, 1, true), after(body.rate, kRate, 2, true);
  ContactSolver::Strike strike;
  strike.law = {1e6, 1.5, 0};
  strike.velocity_m_per_s = 1;
  const std::array<double, 6> rigid{2, 0, 0, 0, 0, 0};
  before.begin(0, strike, body.gain[0], rigid);
  for (int n = 0; n < 30; ++n)
    static_cast<void>(before.step());
  std::vector<Complex> z(body.rate.size());
  before.read_states(z);
  after.write_states(z);
  after.take_over_rigid(before, 1, 1);
  after.take_over(1, before, 0, body.gain[1], rigid);
  const contact::Exciter &old = before.contact(0).exciter, &now = after.contact(1).exciter;
  CHECK(now.depth_m == approx(old.depth_m).epsilon(1e-12));
  double surface = 2 * (old.position_m - old.depth_m) / 2, was = 0, is = 0;
  for (std::size_t k = 0; k < z.size(); ++k) {
    was += body.gain[0][k] * z[k].imag() / body.rate[k].imag();
    is += body.gain[1][k] * z[k].imag() / body.rate[k].imag();
  }
  surface += is - was;
  CHECK(now.position_m - now.depth_m == approx(surface).epsilon(1e-6));
  CHECK(now.impact.stored_j() == old.impact.stored_j());
}

TEST_CASE("two rough surfaces on one body have different noise") {
  const Body body;
  ContactSolver solver(body.rate, kRate, 2, false);
  contact::FrictionLaw law;
  law.roughness = 1;
  for (std::size_t i = 0; i < 2; ++i)
    solver.begin_rub(i, law, body.gain[0], {});
  double difference = 0;
  for (int n = 0; n < 100; ++n) {
    for (std::size_t i = 0; i < 2; ++i)
      solver.rub(i, 1, 0.5);
    static_cast<void>(solver.step());
    difference += std::abs(solver.contact(0).exciter.force_n - solver.contact(1).exciter.force_n);
  }
  CHECK(difference > 1e-3);
}

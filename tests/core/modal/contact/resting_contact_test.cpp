// Contacts between two bodies in the solver: what they may never do, and what they are in theory.
#include "core/modal/contact/contact_solver.hpp"
#include "tests/core/modal/contact/reference.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::contact::ImpactLaw;
using Rigid = std::array<double, ContactSolver::kRigid>;

namespace {

constexpr double kGravity = 9.81;

Complex rate_of(double hz, double decay) { return {-decay, 2 * kPi * hz}; }

/// A bar of three modes, free to move along one axis and to turn, on a board of three modes, at two
/// points. Gains along the direction that pushes the bar up and the board down.
struct BarOnBoard {
  double mass = 0.08, inertia = 2e-4; // kg, kg m^2
  std::vector<Complex> rate{rate_of(310, 2), rate_of(860, 5),  rate_of(1690, 9),
                            rate_of(95, 12), rate_of(240, 20), rate_of(415, 30)};
  std::array<double, 2> position{-0.06, 0.05}; // m from the centre of mass
  std::array<std::vector<double>, 2> gain{std::vector<double>{1.3, -2.9, 3.3, -0.9, 1.1, 0.4},
                                          std::vector<double>{0.8, 2.1, 3.9, -0.7, -0.8, 1.2}};
  std::vector<double> struck{-5.1, 0.2, 4.4, 0, 0, 0}; // downwards, on the bar

  [[nodiscard]] Rigid rigid(double x) const {
    return {1 / std::sqrt(mass), x / std::sqrt(inertia)};
  }
  /// Static forces of the weight.
  [[nodiscard]] std::array<double, 2> preload() const {
    const double share = position[1] / (position[1] - position[0]);
    return {mass * kGravity * share, mass * kGravity * (1 - share)};
  }
  [[nodiscard]] ContactSolver solver(const ImpactLaw& law, double sample_rate = kRate) const {
    ContactSolver solver(rate, sample_rate, 3, true);
    for (std::size_t i = 0; i < 2; ++i)
      solver.begin_resting_contact(1 + i, {law, preload()[i]}, gain[i], rigid(position[i]));
    return solver;
  }
  void strike(ContactSolver& solver, double speed) const {
    ContactSolver::Strike ball;
    ball.law = {2e6, 1.5, 0};
    ball.velocity_m_per_s = speed;
    Rigid down = rigid(0.01);
    for (double& b : down)
      b = -b;
    solver.begin(0, ball, struck, down);
  }
};

/// Error of the modes' velocities after a push, over their size, beside an integration of the same
/// bodies in their own coordinates: the weight acts, and both bodies are bent by it.
double error(const BarOnBoard& bodies, const ImpactLaw& law, double push, double sample_rate,
             bool& opened) {
  FineIntegration fine;
  std::array<double, 6> bent{};
  for (std::size_t k = 0; k < 6; ++k) {
    for (std::size_t i = 0; i < 2; ++i)
      bent[k] += bodies.gain[i][k] * bodies.preload()[i] / norm(bodies.rate[k]);
    fine.add(bodies.rate[k], bent[k], k == 0 ? push : 0); // the bar's first mode
  }
  fine.add(0, 0, 0, -kGravity * std::sqrt(bodies.mass)); // lift
  fine.add(0, 0, 0);                                     // turn
  for (std::size_t i = 0; i < 2; ++i) {
    double depth = std::pow(bodies.preload()[i] / law.stiffness, 1 / law.exponent);
    std::vector<double> gain = bodies.gain[i];
    for (std::size_t k = 0; k < 6; ++k)
      depth += gain[k] * bent[k];
    const Rigid rigid = bodies.rigid(bodies.position[i]);
    gain.insert(gain.end(), {rigid[0], rigid[1]});
    fine.contacts.push_back({law, depth, gain});
  }
  ContactSolver solver = bodies.solver(law, sample_rate);
  solver.set_state(0, push);
  double difference = 0, size = 0;
  opened = false;
  for (int n = 0; n < static_cast<int>(0.02 * sample_rate); ++n) {
    static_cast<void>(solver.step());
    fine.step(1 / sample_rate, 16);
    for (std::size_t k = 0; k < 6; ++k) {
      const Complex z = solver.state(k), s = bodies.rate[k];
      difference += std::pow(z.real() + s.real() * z.imag() / s.imag() - fine.velocity(k), 2);
      size += fine.velocity(k) * fine.velocity(k);
    }
    opened |= solver.contact(1).exciter.force_n == 0;
  }
  return std::sqrt(difference / size);
}

} // namespace

TEST_CASE("two bodies at rest on each other stay at rest") {
  const BarOnBoard bodies;
  for (const double loss : {0.0, 1.0}) {
    ContactSolver solver = bodies.solver({3e5, 1.5, loss});
    for (int n = 0; n < 2000; ++n) {
      CHECK(solver.step() == 0); // no striker presses
      for (std::size_t i = 0; i < 2; ++i)
        REQUIRE(std::abs(solver.net_contact_force(1 + i)) < 1e-12);
    }
    for (std::size_t i = 0; i < 2; ++i)
      CHECK(solver.contact(1 + i).exciter.force_n == approx(bodies.preload()[i]));
    for (std::size_t k = 0; k < 6; ++k)
      CHECK(abs(solver.state(k)) < 1e-13);
  }
}

TEST_CASE("two bodies that touch move as a fine integration of their own equations does") {
  const BarOnBoard bodies;
  bool opened = false;
  // The points stay closed, then rattle. A softer push hardly bends the law.
  CHECK(error(bodies, {3e5, 1.5, 0}, 0.002, kRate, opened) < 2e-4);
  CHECK_FALSE(opened);
  CHECK(error(bodies, {1e4, 1, 0.5}, 0.01, kRate, opened) < 2e-4);
  CHECK(error(bodies, {3e5, 1.5, 0.4}, 0.2, kRate, opened) < 5e-3);
  CHECK(opened);
  // Of second order in the step.
  const double coarse = error(bodies, {3e5, 1.5, 0}, 0.01, kRate, opened),
               fine = error(bodies, {3e5, 1.5, 0}, 0.01, 2 * kRate, opened);
  CHECK(fine < 0.3 * coarse);
  CHECK(fine > 0.15 * coarse);
}

TEST_CASE("two bodies that touch never gain energy, and keep it all where nothing takes it") {
  for (const double loss : {0.0, 2.0})
    for (const double stiffness : {1e3, 1e6, 1e13}) {
      CAPTURE(loss);
      CAPTURE(stiffness);
      BarOnBoard bodies;
      if (loss == 0)
        for (Complex& s : bodies.rate)
          s = {0, s.imag()};
      ContactSolver solver = bodies.solver({stiffness, 1.5, loss});
      bodies.strike(solver, 1.5);
      const double rest = bodies.solver({stiffness, 1.5, loss}).energy();
      const double given = rest + 0.5 * 0.01 * 1.5 * 1.5; // the striker's
      double before = given;
      bool apart = false;
      for (int n = 0; n < 20000; ++n) {
        static_cast<void>(solver.step());
        apart |= solver.contact(1).exciter.force_n == 0;
        const double energy = solver.energy();
        REQUIRE(energy < before + 1e-12 * given);
        before = energy;
      }
      CHECK(apart == (stiffness > 1e3));
      if (loss > 0)
        CHECK(before < given - 0.4 * (given - rest));
      else if (!apart) // 20 000 steps' rounding
        CHECK(std::abs(before / given - 1) < 1e-10);
      else if (stiffness <= 1e6) // an opening contact drops its account; an unresolved one loses
        CHECK(std::abs(before / given - 1) < 1e-8);
    }
}

namespace {

void check_random_bodies(int count) {
  std::mt19937 random(15);
  std::uniform_real_distribution<double> exponent(1, 6), ten(0, 1);
  for (int round = 0; round < count; ++round) {
    std::vector<Complex> rate;
    std::vector<std::vector<double>> gain(4);
    for (int k = 0; k < 7; ++k) {
      rate.push_back(rate_of(20 * std::pow(3000, ten(random)), 100 * ten(random)));
      for (auto& g : gain)
        g.push_back(20 * ten(random) - 10);
    }
    ContactSolver solver(rate, kRate, 4, true);
    for (std::size_t i = 1; i < 4; ++i)
      solver.begin_resting_contact(
          i,
          {{std::pow(10, 18 * ten(random)), exponent(random), 5 * ten(random)},
           std::pow(10, 6 * ten(random) - 3)},
          gain[i], {10 * ten(random), ten(random), 0, 0, ten(random), 0});
    ContactSolver::Strike ball;
    ball.law = {std::pow(10, 4 + 8 * ten(random)), 1.5, 0};
    ball.mass_kg = std::pow(10, -4 * ten(random));
    solver.begin(0, ball, gain[0], {-3, 1, 0, 0, 0, 0});
    solver.set_state(0, 1);
    double before = solver.energy();
    const double scale = std::abs(before) + 1;
    for (int n = 0; n < 500; ++n) {
      static_cast<void>(solver.step());
      const double energy = solver.energy();
      REQUIRE(std::isfinite(energy));
      REQUIRE(energy < before + 1e-9 * scale);
      before = energy;
    }
  }
}

} // namespace

TEST_CASE("any two resting bodies stay finite and passive") { check_random_bodies(40); }
TEST_CASE("any of 300 pairs of resting bodies stays finite and passive" *
          doctest::test_suite("slow")) {
  check_random_bodies(300);
}

// Contacts between two bodies in the solver: what they may never do, and what they are in theory.
#include "core/modal/contact/contact_solver.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

using namespace tactus::modal;
using Complex = std::complex<double>;
using Rigid = std::array<double, ContactSolver::kRigid>;

namespace {

constexpr double kPi = std::numbers::pi, kRate = 48000, kGravity = 9.81;

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
  [[nodiscard]] ContactSolver solver(const tactus::contact::ImpactLaw& law,
                                     double sample_rate = kRate) const {
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

/// The same motion by the classical Runge-Kutta method, in the bodies' own coordinates: the weight
/// acts, and both bodies are bent by it.
struct Reference {
  const BarOnBoard& bodies;
  tactus::contact::ImpactLaw law;
  static constexpr std::size_t kCount = 8; // six modes, lift and turn
  using State = std::array<double, 2 * kCount>;
  State state{};
  std::array<double, kCount> at_rest{};
  std::array<double, 2> equilibrium{};

  Reference(const BarOnBoard& of, const tactus::contact::ImpactLaw& by) : bodies(of), law(by) {
    for (std::size_t k = 0; k < 6; ++k) {
      for (std::size_t i = 0; i < 2; ++i)
        at_rest[k] += gain(i, k) * bodies.preload()[i];
      at_rest[k] /= std::norm(bodies.rate[k]);
      state[k] = at_rest[k];
    }
    for (std::size_t i = 0; i < 2; ++i)
      equilibrium[i] = std::pow(bodies.preload()[i] / law.stiffness, 1 / law.exponent);
  }
  [[nodiscard]] double gain(std::size_t point, std::size_t k) const {
    return k < 6 ? bodies.gain[point][k] : bodies.rigid(bodies.position[point])[k - 6];
  }
  [[nodiscard]] State slope(const State& x) const {
    State d{};
    std::array<double, 2> force{};
    for (std::size_t i = 0; i < 2; ++i) {
      double apart = 0, velocity = 0;
      for (std::size_t k = 0; k < kCount; ++k) {
        apart += gain(i, k) * (x[k] - at_rest[k]);
        velocity += gain(i, k) * x[kCount + k];
      }
      force[i] = law.force(equilibrium[i] - apart, -velocity);
    }
    for (std::size_t k = 0; k < kCount; ++k) {
      d[k] = x[kCount + k];
      for (std::size_t i = 0; i < 2; ++i)
        d[kCount + k] += gain(i, k) * force[i];
      if (k < 6)
        d[kCount + k] +=
            2 * bodies.rate[k].real() * x[kCount + k] - std::norm(bodies.rate[k]) * x[k];
    }
    d[kCount + 6] -= kGravity * std::sqrt(bodies.mass);
    return d;
  }
  void step(double h) {
    const auto plus = [](const State& a, const State& b, double by) {
      State sum = a;
      for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] += by * b[i];
      return sum;
    };
    const State k1 = slope(state), k2 = slope(plus(state, k1, h / 2)),
                k3 = slope(plus(state, k2, h / 2)), k4 = slope(plus(state, k3, h));
    for (std::size_t i = 0; i < state.size(); ++i)
      state[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
};

/// Velocity of a mode from its state.
double velocity(const ContactSolver& solver, const std::vector<Complex>& rate, std::size_t k) {
  const Complex z = solver.state(k);
  return z.real() + rate[k].real() * z.imag() / rate[k].imag();
}

/// Error of the modes' velocities against the reference after a push, over their size.
double error(const BarOnBoard& bodies, const tactus::contact::ImpactLaw& law, double push,
             double sample_rate, bool& opened) {
  ContactSolver solver = bodies.solver(law, sample_rate);
  Reference reference(bodies, law);
  solver.set_state(0, push);
  reference.state[Reference::kCount] = push; // the velocity of the bar's first mode
  const auto frames = static_cast<int>(0.05 * sample_rate);
  constexpr int kFine = 64;
  double difference = 0, size = 0;
  opened = false;
  for (int n = 0; n < frames; ++n) {
    static_cast<void>(solver.step());
    for (int i = 0; i < kFine; ++i)
      reference.step(1 / (sample_rate * kFine));
    for (std::size_t k = 0; k < 6; ++k) {
      const double true_velocity = reference.state[Reference::kCount + k];
      difference += std::pow(velocity(solver, bodies.rate, k) - true_velocity, 2);
      size += true_velocity * true_velocity;
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
    for (int n = 0; n < 20000; ++n) {
      CHECK(solver.step() == 0); // no striker presses
      for (std::size_t i = 0; i < 2; ++i)
        REQUIRE(std::abs(solver.net_contact_force(1 + i)) < 1e-12);
    }
    for (std::size_t i = 0; i < 2; ++i)
      CHECK(solver.contact(1 + i).exciter.force_n == doctest::Approx(bodies.preload()[i]));
    for (std::size_t k = 0; k < 6; ++k)
      CHECK(std::abs(solver.state(k)) < 1e-13);
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
    for (const double stiffness : {1e3, 1e6, 1e9, 1e13}) {
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

TEST_CASE("a contact conserves momentum between two bodies") {
  // Two free masses, each a mode of next to no frequency, and a ringing mode on each; a force
  // presses them together.
  const double one = 0.05, two = 0.3;
  const std::vector<Complex> rate{{0, 1e-7}, {0, 1e-7}, rate_of(430, 0), rate_of(270, 0)};
  const std::vector<double> gain{1 / std::sqrt(one), -1 / std::sqrt(two), 2.2, -1.9};
  for (const double preload : {0.0, 4.0}) {
    ContactSolver solver(rate, kRate, 1, false);
    solver.begin_resting_contact(0, {{2e6, 1.5, 0.3}, preload}, gain, {});
    const auto momentum = [&] {
      return std::sqrt(one) * solver.state(0).real() + std::sqrt(two) * solver.state(1).real();
    };
    solver.set_state(0, -0.5 * std::sqrt(one)); // the one comes at half a metre a second
    solver.set_state(2, 0.05);
    const double given = momentum();
    double exchanged = 0;
    for (int n = 0; n < 4000; ++n) {
      static_cast<void>(solver.step());
      exchanged += std::abs(solver.net_contact_force(0)) / kRate;
      REQUIRE(std::abs(momentum() / given - 1) < 1e-12);
    }
    CHECK(exchanged > 0.02); // of 0.025 N s
    CHECK(solver.state(1).real() * std::sqrt(two) < -1e-3);
  }
}

TEST_CASE("two modes joined by a spring ring at the eigenfrequencies of both together") {
  const std::array<double, 2> omega{2 * kPi * 210, 2 * kPi * 330}, b{2.4, -1.7};
  const std::vector<Complex> rate{{0, omega[0]}, {0, omega[1]}};
  for (const double k : {2e4, 2e5, 1.5e6}) {
    CAPTURE(k);
    ContactSolver solver(rate, kRate, 1, false);
    solver.begin_resting_contact(0, {{k, 1, 0}, 5}, b, {}); // pressed so that it never opens
    solver.set_state(0, 1e-4);
    // Eigenvalues of diag(omega^2) + k b b^T.
    const double p = omega[0] * omega[0] + k * b[0] * b[0], q = k * b[0] * b[1],
                 r = omega[1] * omega[1] + k * b[1] * b[1];
    const double middle = 0.5 * (p + r), apart = std::hypot(0.5 * (p - r), q);
    const std::array<double, 2> expected{std::sqrt(middle - apart), std::sqrt(middle + apart)};
    std::vector<double> x;
    for (int n = 0; n < 6000; ++n) {
      static_cast<void>(solver.step());
      REQUIRE(solver.contact(0).exciter.force_n > 0);
      x.push_back(solver.state(0).imag());
    }
    // Two tones obey x[n+2] + x[n-2] = u (x[n+1] + x[n-1]) - w x[n], u = 2 (c1 + c2),
    // w = 2 + 4 c1 c2, c the cosines of their angles a (coarser) step.
    constexpr std::size_t kStride = 12;
    double uu = 0, uw = 0, ww = 0, us = 0, ws = 0;
    for (std::size_t n = 2 * kStride; n + 2 * kStride < x.size(); ++n) {
      const double sum = x[n + 2 * kStride] + x[n - 2 * kStride],
                   u = x[n + kStride] + x[n - kStride], w = -x[n];
      uu += u * u, uw += u * w, ww += w * w, us += u * sum, ws += w * sum;
    }
    const double determinant = uu * ww - uw * uw;
    const double u = (us * ww - ws * uw) / determinant, w = (ws * uu - us * uw) / determinant;
    const double root = std::sqrt(u * u / 16 - (w - 2) / 4);
    const std::array<double, 2> found{std::acos(u / 4 + root) / kStride * kRate,
                                      std::acos(u / 4 - root) / kStride * kRate};
    for (std::size_t i = 0; i < 2; ++i)
      // A contact's frequency is low by its angle squared over twelve.
      CHECK(found[i] ==
            doctest::Approx(expected[i]).epsilon(1e-6 + std::pow(expected[i] / kRate, 2) / 12));
  }
}

TEST_CASE("a contact without stiffness leaves the bodies alone") {
  const BarOnBoard bodies;
  ContactSolver alone(bodies.rate, kRate, 3, true), contacting(bodies.rate, kRate, 3, true);
  for (std::size_t i = 0; i < 2; ++i)
    contacting.begin_resting_contact(1 + i, {{1e-3, 1, 0}, 0}, bodies.gain[i],
                                     bodies.rigid(bodies.position[i]));
  bodies.strike(alone, 1);
  bodies.strike(contacting, 1);
  for (int n = 0; n < 2000; ++n) {
    if (!alone.touching())
      break;
    CHECK(alone.step() == doctest::Approx(contacting.step()).epsilon(1e-6));
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(std::abs(alone.state(k) - contacting.state(k)) < 1e-7);
  }
  for (std::size_t k = 3; k < 6; ++k)
    CHECK(std::abs(contacting.state(k)) < 1e-6); // the board's
}

TEST_CASE("any two resting bodies stay finite and passive") {
  std::mt19937 random(15);
  std::uniform_real_distribution<double> exponent(1, 6), ten(0, 1);
  for (int round = 0; round < 300; ++round) {
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

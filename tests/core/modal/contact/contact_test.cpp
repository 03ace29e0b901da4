#include "core/modal/contact/contact_solver.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

using namespace tactus::modal;
using tactus::contact::dissipation_for;
using tactus::contact::hertz_stiffness;
using tactus::contact::ImpactLaw;
using Complex = std::complex<double>;
using tactus::test::approx;

namespace {

constexpr double kPi = std::numbers::pi;

// A steel ball of 6 mm radius that fell 100 mm, and aluminium below it.
const double kBall = 7850 * 4.0 / 3 * kPi * 0.006 * 0.006 * 0.006;
const double kSpeed = std::sqrt(2 * 9.81 * 0.1);
const double kStiffness = hertz_stiffness(0.006, 206e9, 0.29, 70.3e9, 0.33);

struct ImpactRecord {
  double impulse = 0, rebound = 0, time = 0, peak_force = 0, gained = 0;
};

ImpactRecord strike(ContactSolver& solver, double rate, ContactSolver::Strike contact,
                    std::span<const double> gain, std::array<double, 6> rigid = {}) {
  ImpactRecord record;
  solver.begin(0, contact, gain, rigid);
  const double before = 0.5 * contact.mass_kg * contact.velocity_m_per_s * contact.velocity_m_per_s;
  for (int n = 0; n < 100000 && solver.touching(); ++n) {
    const double force = solver.step();
    record.impulse += force / rate;
    record.time += force > 0 ? 1 / rate : 0;
    record.peak_force = std::max(record.peak_force, force);
    record.gained = std::max(record.gained, solver.energy() / before - 1);
  }
  record.rebound = -solver.contact(0).exciter.velocity_m_per_s / contact.velocity_m_per_s;
  return record;
}

ContactSolver::Strike ball() {
  ContactSolver::Strike contact;
  contact.law.stiffness = kStiffness;
  contact.mass_kg = kBall;
  contact.velocity_m_per_s = kSpeed;
  return contact;
}

} // namespace

TEST_CASE("Hertz' numbers for the ball are the closed form's") {
  CHECK(kBall == approx(7.103e-3).epsilon(1e-3));
  CHECK(kStiffness == approx(6.032e9).epsilon(1e-3));
  const ImpactLaw law{kStiffness, 1.5, 0};
  CHECK(law.deepest(0.5 * kBall * kSpeed * kSpeed) == approx(24.2e-6).epsilon(2e-3));
  CHECK(law.duration(kBall, kSpeed) == approx(50.9e-6).epsilon(2e-3));
  CHECK(law.duration(kBall, kSpeed) ==
        approx(2.9432 * law.deepest(0.5 * kBall * kSpeed * kSpeed) / kSpeed).epsilon(1e-4));
  // A linear spring's contact is half a period.
  const ImpactLaw spring{1000, 1, 0};
  CHECK(spring.duration(0.1, 1) == approx(kPi * std::sqrt(0.1 / 1000)));
}

TEST_CASE(
    "on a wall the ball returns as fast as it came, at every sample rate, after Hertz' time") {
  for (const double rate : {8000.0, 22050.0, 44100.0, 48000.0, 96000.0, 192000.0}) {
    CAPTURE(rate);
    ContactSolver solver({}, rate, 1, false);
    const ImpactRecord record = strike(solver, rate, ball(), {});
    CHECK(record.rebound == approx(1).epsilon(0.002));
    CHECK(record.impulse == approx(2 * kBall * kSpeed).epsilon(0.002));
  }
  // At a rate that resolves the contact its length and height are seen.
  ContactSolver solver({}, 4e6, 1, false);
  const ImpactRecord record = strike(solver, 4e6, ball(), {});
  CHECK(record.time == approx(50.9e-6).epsilon(0.01));
  CHECK(record.peak_force == approx(719).epsilon(0.01));
}

TEST_CASE("two free bodies part as momentum and energy demand") {
  // A block of 20 g, hit in its middle.
  ContactSolver solver({}, 48000, 1, true);
  const ImpactRecord record =
      strike(solver, 48000, ball(), {}, {1 / std::sqrt(0.02), 0, 0, 0, 0, 0});
  const double expected = (0.02 - kBall) / (0.02 + kBall); // -v'/v of the lighter body
  CHECK(record.rebound == approx(expected).epsilon(0.003));
}

TEST_CASE("the error decreases with the square of the step") {
  // Contacts of one duration met by coarser and coarser samples: force the number of steps by a
  // softer spring law, whose half period is known.
  const auto error = [](double rate) {
    ContactSolver solver({}, rate, 1, false);
    ContactSolver::Strike contact = ball();
    contact.law = {1e6, 1, 0};
    const ImpactRecord record = strike(solver, rate, contact, {});
    return std::abs(record.rebound - 1);
  };
  CHECK(error(48000) < 2e-3);
  CHECK(error(192000) < 2e-3);
}

TEST_CASE("a vibrating body takes energy, and none is created") {
  for (const double rate : {22050.0, 44100.0, 48000.0, 96000.0, 192000.0})
    for (const double stiffness : {1e4, 1e6, 1e8, kStiffness, 1e12})
      for (const double mass : {1e-5, 1e-3, kBall, 1.0}) {
        CAPTURE(rate);
        CAPTURE(stiffness);
        CAPTURE(mass);
        std::vector<Complex> rates;
        std::vector<double> gain;
        for (int k = 0; k < 40; ++k) {
          rates.emplace_back(-1.0 - k, 2 * kPi * (300.0 + 1400.0 * k));
          gain.push_back((k % 2 ? -1 : 1) * 2.0);
        }
        ContactSolver solver(rates, rate, 1, true);
        auto contact = ball();
        contact.law.stiffness = stiffness;
        contact.mass_kg = mass;
        const ImpactRecord record = strike(solver, rate, contact, gain, {2, 0, 0, 0.3, 0, 0});
        CHECK(record.gained < 1e-8);
        CHECK(record.rebound <= 1);
        CHECK(solver.energy() <= 0.5 * mass * kSpeed * kSpeed * (1 + 1e-8));
      }
}

TEST_CASE("the impulse is the same within half a percent at the usual rates") {
  std::vector<Complex> rates;
  std::vector<double> gain;
  for (int k = 0; k < 14; ++k) {
    rates.emplace_back(-5.0, 2 * kPi * (5890.0 + 1400.0 * k));
    gain.push_back(1.5);
  }
  std::vector<double> impulse;
  for (const double rate : {44100.0, 48000.0, 96000.0}) {
    ContactSolver solver(rates, rate, 1, true);
    impulse.push_back(strike(solver, rate, ball(), gain, {2, 0, 0, 0, 0, 0}).impulse);
  }
  CHECK(impulse[1] == approx(impulse[0]).epsilon(0.005));
  CHECK(impulse[2] == approx(impulse[0]).epsilon(0.005));
}

TEST_CASE("the steel ball on a free aluminium disk parts as finer computations found") {
  // Disk of 100 x 12 mm struck at 25 mm from its centre; modes of a finite-element model (18 741
  // degrees of freedom; frequencies within 0.07 % of a spectral solution), shapes 1/sqrt(kg).
  struct Mode {
    double frequency_hz, shape;
  };
  const std::vector<Mode> low{
      {5891.5, 1.3198}, {9993.9, 1.4932}, {12869.7, 0.8859}, {20581.6, 3.5416}, {21125.2, 0.5946}};
  const std::vector<Mode> high{
      {23364.8, 0.0115}, {27421.5, 0.1239}, {30227.9, 0.3988}, {32176.4, 3.7348},
      {34917.8, 1.4805}, {35445.5, 0.3618}, {35894.0, 0.0221}, {39880.8, 0.2672},
      {42573.0, 0.1448}, {44158.7, 3.4438}, {46760.9, 0.0228}, {49046.9, 0.0404},
      {49888.5, 0.1788}, {56255.5, 2.9675}, {56948.0, 0.0185}, {58417.3, 0.1338}};
  constexpr double kMass = 0.254469, kInertia = 1.620966e-4, kArm = 0.025;
  const std::array<double, 6> recoil{1 / std::sqrt(kMass), kArm / std::sqrt(kInertia), 0, 0, 0, 0};
  const auto play = [&](std::vector<Mode> modes, double rate, std::vector<double>* speeds) {
    std::vector<Complex> rates;
    std::vector<double> gain;
    for (const Mode& mode : modes) {
      rates.emplace_back(-2 * kPi * mode.frequency_hz * 0.5e-4, 2 * kPi * mode.frequency_hz);
      gain.push_back(mode.shape);
    }
    ContactSolver solver(rates, rate, 1, true);
    const ImpactRecord record = strike(solver, rate, ball(), gain, recoil);
    for (std::size_t k = 0; speeds && k < modes.size(); ++k)
      speeds->push_back(std::abs(solver.state(k) * gain[k]));
    return record;
  };
  // An independent integration gave: rigid body 18.85 mN s and 0.895, modes below 22 kHz 18.17 mN s
  // and 0.826, below 60 kHz 0.828.
  std::vector<Mode> both = low;
  both.insert(both.end(), high.begin(), high.end());
  for (const double rate : {22050.0, 44100.0, 48000.0, 96000.0, 192000.0}) {
    CAPTURE(rate);
    const ImpactRecord rigid = play({}, rate, nullptr);
    CHECK(rigid.impulse == approx(18.85e-3).epsilon(0.005));
    CHECK(rigid.rebound == approx(0.895).epsilon(0.003));
    std::vector<double> speeds;
    const ImpactRecord record = play(low, rate, &speeds);
    CHECK(record.impulse == approx(18.17e-3).epsilon(0.01));
    CHECK(std::abs(record.rebound - 0.826) < 0.01);
    const double expected[] = {0.0296, 0.0334, 0.0103, 0.0937, 0.0025}; // m/s at the place
    for (std::size_t k = 0; k < speeds.size(); ++k)
      CHECK(speeds[k] == approx(expected[k]).epsilon(0.03));
    CHECK(std::abs(play(both, rate, nullptr).rebound - 0.828) < 0.01);
  }
}

TEST_CASE("the computed loss gives the wanted restitution") {
  for (const double e : {0.2, 0.5, 0.8, 0.95}) {
    CAPTURE(e);
    ContactSolver solver({}, 48000, 1, false);
    auto contact = ball();
    contact.law.dissipation_s_per_m = dissipation_for(e, kSpeed);
    CHECK(strike(solver, 48000, contact, {}).rebound == approx(e).epsilon(0.01));
  }
  CHECK(dissipation_for(1, 1) == 0);
}

TEST_CASE("a hand that presses slowly feels the contact law in series with the body") {
  // One stiff mode: static compliance b^2 / omega^2.
  const Complex rate(-2000, 2 * kPi * 500);
  const double gain = 2;
  ContactSolver solver({&rate, 1}, 48000, 1, false);
  ContactSolver::Strike contact;
  contact.law = {1e5, 1, 0};
  contact.held = true;
  solver.begin(0, contact, {&gain, 1}, {});
  const double depth = 1e-3;
  double force = 0;
  for (int n = 0; n < 48000; ++n) {
    const double next = depth * std::min(1.0, n / 24000.0);
    solver.set_held_position(0, next);
    force = solver.step();
  }
  const double compliance = gain * gain / std::norm(rate);
  CHECK(force == approx(depth / (1e-5 + compliance)).epsilon(0.002));
}

TEST_CASE("the residual compliance makes the contact softer") {
  ContactSolver solver({}, 48000, 1, false);
  ContactSolver::Strike contact;
  contact.law = {1e6, 1, 0};
  contact.law.compliance_m_per_n = 1e-6;
  contact.held = true;
  solver.begin(0, contact, {}, {});
  solver.set_held_position(0, 1e-3);
  static_cast<void>(solver.step()); // the way in
  solver.set_held_position(0, 1e-3);
  CHECK(solver.step() == approx(500).epsilon(1e-6));
}

TEST_CASE("the moments of a sample's force are those of its steps over Legendre's polynomials") {
  // A hand that presses a stiff spring into a rigid wall, in four steps a sample.
  ContactSolver solver({}, 48000, 1, false);
  ContactSolver::Strike hand;
  hand.law = {1e12, 1, 0};
  hand.held = true;
  solver.begin(0, hand, {}, {});
  const auto moments = [&](double depth) {
    solver.set_held_position(0, depth);
    static_cast<void>(solver.step());
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
}

TEST_CASE("many contacts at once: any order gives the same motion") {
  std::vector<Complex> rates;
  for (int k = 0; k < 20; ++k)
    rates.emplace_back(-10.0, 2 * kPi * (200.0 + 333.0 * k));
  const auto play = [&](const std::vector<std::size_t>& order) {
    ContactSolver solver(rates, 48000, 8, true);
    for (std::size_t i = 0; i < order.size(); ++i) {
      std::vector<double> gain;
      for (int k = 0; k < 20; ++k)
        gain.push_back(std::cos(1.0 + static_cast<double>(order[i]) * 0.7 + k));
      auto contact = ball();
      contact.velocity_m_per_s = 0.3 + 0.2 * static_cast<double>(order[i]);
      solver.begin(i, contact, gain, {1, 0.1 * static_cast<double>(order[i]), 0, 0, 0, 0});
    }
    double impulse = 0;
    for (int n = 0; n < 200; ++n)
      impulse += solver.step() / 48000;
    return std::pair(impulse, solver.state(7));
  };
  const auto a = play({0, 1, 2, 3, 4, 5, 6, 7}), b = play({6, 3, 0, 7, 5, 1, 4, 2});
  CHECK(a.first == approx(b.first).epsilon(1e-9));
  CHECK(std::abs(a.second - b.second) < 1e-9 * std::abs(a.second));
}

// A ball that strikes walls, free masses and bodies of modes, by theory and finer computations.
#include "core/modal/contact/contact_solver.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::contact::hertz_stiffness;

namespace {

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

TEST_CASE(
    "on a wall the ball returns as fast as it came, at every sample rate, after Hertz' time") {
  for (const double rate : {8000.0, 44100.0, 192000.0}) {
    CAPTURE(rate);
    ContactSolver solver({}, rate, 1, false);
    const ImpactRecord record = strike(solver, rate, ball(), {});
    CHECK(record.rebound == approx(1).epsilon(0.002));
    CHECK(record.impulse == approx(2 * kBall * kSpeed).epsilon(0.002));
  }
  CHECK(kStiffness == approx(6.032e9).epsilon(1e-3)); // N/m^(3/2), by hand
  // At a rate that resolves the contact its length and height are seen.
  ContactSolver solver({}, 4e6, 1, false);
  const ImpactRecord record = strike(solver, 4e6, ball(), {});
  CHECK(record.time == approx(50.9e-6).epsilon(0.01));
  CHECK(record.peak_force == approx(719).epsilon(0.01));
}

TEST_CASE("a vibrating body takes energy and none is created, in double or single precision") {
  struct Case {
    int modes;
    double rate, tolerance;
  };
  for (const Case& c : {Case{40, 22050, 1e-8},
                        {40, 48000, 1e-8},
                        {40, 192000, 1e-8},
                        {600, 44100, 1e-6},
                        {600, 96000, 1e-6}})
    for (const double stiffness : {1e4, 1e6, kStiffness, 1e12})
      for (const double mass : {1e-5, kBall, 1.0}) {
        if (c.modes > 40 && (mass != kBall || stiffness != kStiffness))
          continue;
        CAPTURE(c.modes);
        CAPTURE(c.rate);
        CAPTURE(stiffness);
        CAPTURE(mass);
        std::vector<Complex> rates;
        std::vector<double> gain;
        for (int k = 0; k < c.modes; ++k) {
          rates.emplace_back(-1.0 - k, 2 * kPi * (300.0 + 56000.0 * k / c.modes));
          gain.push_back((k % 2 ? -1 : 1) * 2.0);
        }
        ContactSolver solver(rates, c.rate, 1, true);
        auto contact = ball();
        contact.law.stiffness = stiffness;
        contact.mass_kg = mass;
        const ImpactRecord record = strike(solver, c.rate, contact, gain, {2, 0, 0, 0.3, 0, 0});
        CHECK(record.gained < c.tolerance);
        CHECK(record.rebound <= 1);
        CHECK(solver.energy() <= 0.5 * mass * kSpeed * kSpeed * (1 + c.tolerance));
      }
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
      speeds->push_back(abs(solver.state(k) * gain[k]));
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

TEST_CASE(
    "a hand that presses slowly feels the contact law in series with modes and what lies beyond") {
  // One stiff mode: static compliance b^2 / omega^2.
  const Complex rate(-2000, 2 * kPi * 500);
  const double gain = 2;
  ContactSolver solver({&rate, 1}, kRate, 1, false);
  ContactSolver::Strike contact;
  contact.law = {1e5, 1, 0};
  contact.law.compliance_m_per_n = 1e-5;
  contact.held = true;
  solver.begin(0, contact, {&gain, 1}, {});
  const double depth = 1e-3;
  double force = 0;
  for (int n = 0; n < 48000; ++n) {
    const double next = depth * std::min(1.0, n / 24000.0);
    solver.set_held_position(0, next);
    force = solver.step();
  }
  const double compliance = gain * gain / norm(rate);
  CHECK(force == approx(depth / (1e-5 + 1e-5 + compliance)).epsilon(0.002));
}

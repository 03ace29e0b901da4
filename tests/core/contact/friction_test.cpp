#include "core/contact/excited_body.hpp"
#include "core/dsp/complex.hpp"
#include "tests/approx.hpp"
#include "tests/core/contact/bodies.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

// A belt drags a damped oscillator, against an integration of the equations of motion with the law
// as Dupont et al. write it.

using namespace tactus::contact;
using tactus::test::approx;

namespace {

constexpr double kRate = 44100;
constexpr double kNepers = 6.907755278982137;
constexpr double kPi = std::numbers::pi;

struct Belt {
  double normal_n;
  FrictionLaw law;
  double mass_kg, frequency_hz, decay_per_s, speed_m_per_s;
};

ExcitedBody make_body(const Belt& belt) {
  ExcitedBody body(1, 1);
  body.prepare(kRate);
  body.set_modes(std::array{Mode{belt.frequency_hz, kNepers / belt.decay_per_s, belt.mass_kg}});
  body.set_friction(0, belt.law);
  body.rub(0, belt.normal_n, belt.speed_m_per_s);
  return body;
}

struct Measured {
  double frequency_hz = 0, rms = 0;
};

/// Of the second half: rms about the mean, and the rate of passages upwards through it.
Measured measure(const std::vector<double>& signal) {
  const std::size_t from = signal.size() / 2, count = signal.size() - from;
  double mean = 0, square = 0;
  for (std::size_t n = from; n < signal.size(); ++n)
    mean += signal[n] / static_cast<double>(count);
  for (std::size_t n = from; n < signal.size(); ++n)
    square += (signal[n] - mean) * (signal[n] - mean) / static_cast<double>(count);
  Measured output{0, std::sqrt(square)};
  double first = -1, last = -1;
  int passages = 0;
  bool armed = false;
  for (std::size_t n = from + 1; n < signal.size(); ++n) {
    const double now = signal[n] - mean, before = signal[n - 1] - mean;
    armed = armed || now < -0.3 * output.rms;
    if (!armed || before >= 0 || now < 0)
      continue;
    armed = false;
    last = static_cast<double>(n - 1) - before / (now - before);
    if (first < 0)
      first = last;
    ++passages;
  }
  if (passages > 1)
    output.frequency_hz = kRate * (passages - 1) / (last - first);
  return output;
}

} // namespace

TEST_CASE("rubbed oscillators speak with the pitch and strength of the law") {
  struct Row {
    Belt belt;
    double frequency_hz, rms;
  };
  // Reference: Runge and Kutta's fourth order, 400 to 2000 steps a sample.
  const Row rows[] = {
      {{5, {.8, .3, .05, .1, 1e4, 5, .2}, .02, 250, 8, .05}, 248.254, .04494},
      {{20, {.8, .3, .1, .5, 1e5, 40, .5}, .05, 120, 6, .1}, 81.325, .12283},
      {{20, {.8, .3, .1, .5, 1e5, 40, .5}, .05, 600, 20, .1}, 600.798, .09652},
      {{100, {.7, .35, .1, .7, 1e6, 200, 1}, .2, 180, 10, .1}, 170.313, .08456},
      {{100, {.7, .35, .1, .7, 1e7, 1000, 1}, .2, 180, 10, .1}, 139.008, .11889},
      {{400, {.7, .35, .05, .7, 1e7, 2000, 5}, 1, 90, 10, .03}, 28.049, .06983},
      {{400, {.7, .35, .05, .7, 1e8, 2000, 5}, 1, 90, 10, .03}, 27.254, .07581},
  };
  for (const Row& row : rows) {
    ExcitedBody body = make_body(row.belt);
    std::vector<double> signal;
    double minimum = 0, before = 0, gained = 0;
    for (int n = 0; n < 44100; ++n) {
      body.step();
      // All that comes in is the work of the belt.
      gained =
          std::max(gained, body.energy() - before - body.force(0) * row.belt.speed_m_per_s / kRate);
      before = body.energy();
      signal.push_back(body.pickup_velocity());
      minimum = std::min(minimum, body.exciter(0).dissipated_j);
    }
    const Measured output = measure(signal);
    MESSAGE(output.frequency_hz, " Hz (", 100 * (output.frequency_hz / row.frequency_hz - 1),
            " %), rms ", output.rms, " (", 100 * (output.rms / row.rms - 1), " %)");
    CHECK(output.frequency_hz == approx(row.frequency_hz).epsilon(1e-3));
    CHECK(output.rms == approx(row.rms).epsilon(5e-3));
    CHECK(gained < 1e-12 * row.belt.normal_n * row.belt.speed_m_per_s / kRate);
    CHECK(minimum >= -1e-12 * row.belt.normal_n * row.belt.speed_m_per_s / kRate);
  }
}

namespace {

/// Every `nth` of 1296 bodies, of all sizes of stiffness, damping, load, speed and mass.
void check_rubbed_bodies(int nth) {
  int number = 0;
  double minimum = 0;
  for (const double stiffness : {1e3, 1e5, 1e7, 1e9})
    for (const double damping : {0.0, 1.0, 100.0, 1e4})
      for (const double normal : {1.0, 50.0, 1000.0})
        for (const double speed : {.01, .3, 3.0})
          for (const double mass : {1e-3, 1e-1, 10.0})
            for (const double frequency : {50.0, 800.0, 8000.0}) {
              if (number++ % nth)
                continue;
              const Belt belt{normal, {.8, .3, .1, .5, stiffness, damping, .3}, mass, frequency, 10,
                              speed};
              ExcitedBody body = make_body(belt);
              // The strongest steady force, at the mode's own impedance, and the belt's speed.
              const double bound = 100 * (speed + 0.8 * normal / (mass * 2 * kPi * frequency));
              double highest = 0;
              for (int n = 0; n < 2205; ++n) {
                body.step();
                highest = std::max(highest, std::abs(body.pickup_velocity()));
                minimum =
                    std::min(minimum, body.exciter(0).dissipated_j * kRate / (normal * speed));
              }
              CHECK(highest < bound);
            }
  CHECK(minimum > -1e-9);
}

/// Modes of 0.5 g on which the default bristles of 1e5 N/m swing 6000 times a second: one step a
/// sample would let the string bear a bow twice as heavy. Amplitude of the fundamental, m/s.
double bowed_fundamental(double force, unsigned min_steps, int samples) {
  constexpr double kHz = 196, kBeta = 0.13, kSpeed = 0.1, kModalMass = 3e-3 * 0.33 / 2;
  std::vector<Mode> modes;
  std::vector<double> shape;
  for (int n = 1; n <= 60; ++n) {
    modes.push_back({kHz * n, 2 / (1 + n * n / 36.), kModalMass});
    shape.push_back(std::sin(n * kPi * kBeta));
  }
  ExcitedBody body(modes.size());
  body.prepare(48000);
  body.set_modes(modes);
  std::vector<double> helmholtz; // the motion in which it is set off
  for (std::size_t n = 0; n < modes.size(); ++n)
    helmholtz.push_back(-2 * kSpeed / (static_cast<double>(n + 1) * kPi * kBeta));
  tactus::test::set_off(body, 0, helmholtz);
  body.set_contact_shape(0, shape);
  body.set_pickup(0, shape);
  FrictionLaw law;
  law.viscosity_ns_per_m = 0;
  body.set_friction(0, law);
  body.set_min_steps(min_steps);
  tactus::Complex sum = 0;
  const int from = samples / 2;
  for (int n = 0; n < samples; ++n) {
    body.rub(0, force, kSpeed);
    body.step();
    CHECK(body.steps() >= 4);
    if (n >= from)
      sum += body.pickup_velocity() * (1 - std::cos(2 * kPi * n / (samples - from))) *
             tactus::math::polar(1.0, -2 * kPi * kHz * n / 48000);
  }
  return 2 * abs(sum) / (samples - from);
}

} // namespace

TEST_CASE("rubbed bodies stay bounded and friction only dissipates") { check_rubbed_bodies(17); }
TEST_CASE("1296 rubbed bodies stay bounded" * doctest::test_suite("slow")) {
  check_rubbed_bodies(1);
}

TEST_CASE("a bowed string takes the steps that its bristles need, and sounds as with more") {
  CHECK(bowed_fundamental(0.15, 1, 9600) ==
        approx(bowed_fundamental(0.15, 16, 9600)).epsilon(0.02));
}
TEST_CASE("a bowed string sounds as with the finest steps, within 0.2 dB" *
          doctest::test_suite("slow")) {
  for (const double force : {0.12, 0.15})
    CHECK(bowed_fundamental(force, 1, 48000) ==
          approx(bowed_fundamental(force, 64, 48000)).epsilon(0.02));
}

#include "core/reed/playability/linear_stability.hpp"

#include "tests/core/reed/reference_instruments.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <string>
#include <vector>

// Expected figures come from an independent implementation of the same linear equations (numpy,
// roots polished in extended precision). They are quoted to five digits, hence the tolerance.
namespace tactus::reed {
namespace {

using Complex = std::complex<double>;
constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kQuoted = 1e-4;

struct ReferenceValue {
  std::string name;
  Parameters instrument;
  double near_hz, pressure, frequency;
};

double relative(double value, double expected) { return std::abs(value / expected - 1); }

std::vector<double> impedance_peaks(const Parameters& p, std::size_t count) {
  const LinearStability theory(p, p.length);
  const auto magnitude = [&](double f) {
    return 1 / std::abs(theory.input_admittance({0, kTwoPi * f}));
  };
  std::vector<double> peaks;
  constexpr double kStep = 0.02;
  for (double f = 20; peaks.size() < count && f < 10000; f += kStep)
    if (magnitude(f) > magnitude(f - kStep) && magnitude(f) >= magnitude(f + kStep))
      peaks.push_back(f);
  return peaks;
}

/// Zeros of Y_in - Y_valve in a rectangle of the right half plane, where neither has a pole, by
/// the principle of the argument: independent of any starting point or iteration.
int zeros_right_of(const LinearStability& theory, double quality, double pressure,
                   double reed_frequency, double abscissa, double highest) {
  const Equilibrium state = theory.equilibrium(pressure, reed_frequency);
  const auto f = [&](Complex s) {
    const double w = kTwoPi * reed_frequency;
    // Without the valve's own pole, whose nearness would hide a zero from the walk.
    const Complex pole = w * w + s * s + s * w / quality;
    return pole * (theory.input_admittance(s) - theory.valve_admittance(s, state, reed_frequency));
  };
  const double width = 3 * highest, lowest = 1e-4 * highest;
  const Complex corners[] = {{abscissa, lowest},
                             {abscissa + width, lowest},
                             {abscissa + width, highest},
                             {abscissa, highest}};
  double turned = 0;
  for (int side = 0; side < 4; ++side) {
    const Complex from = corners[side], edge = corners[(side + 1) % 4] - from;
    double at = 0, step = 1e-3;
    Complex here = f(from);
    while (at < 1) {
      const double next = std::min(1.0, at + step);
      const Complex there = f(from + next * edge);
      const double angle = std::arg(there / here);
      if (std::abs(angle) > 0.3 && step > 1e-12) {
        step *= 0.5;
        continue;
      }
      turned += angle;
      here = there;
      at = next;
      if (std::abs(angle) < 0.1)
        step = std::min(2 * step, 2e-3);
    }
  }
  return static_cast<int>(std::lround(turned / kTwoPi));
}

TEST_CASE("the bore's input impedance peaks where theory puts them") {
  // Half of the last digit quoted, and what a 0.02 Hz search adds.
  const auto check = [](const Parameters& p, std::vector<double> expected, double half_digit) {
    const auto peaks = impedance_peaks(p, expected.size());
    REQUIRE(peaks.size() == expected.size());
    for (std::size_t i = 0; i < peaks.size(); ++i)
      CHECK(std::abs(peaks[i] - expected[i]) < half_digit + 0.04);
  };
  check(reference::clarinet(), {174.3, 526.5, 879.4}, 0.05);
  check(reference::saxophone(), {239.3, 492.2, 773.6}, 0.05);
  check(reference::oboe(), {330.2, 666.4}, 0.05);
  check(reference::trumpet(), {116.7, 239.9, 368.9, 501.5}, 0.05);
  check(reference::trombone(), {40.0, 121.9, 204.1, 286.7}, 0.05);
  check(reference::voice(), {486, 1465}, 0.5);
  check(reference::syrinx(), {1620}, 0.5);
}

TEST_CASE("a valve starts to sing at its threshold pressure, at its threshold pitch") {
  using namespace reference;
  const std::vector<ReferenceValue> figures{
      {"clarinet", clarinet(), 0, 1472.3, 171.96},
      {"short clarinet", clarinet(0.3), 0, 1433.7, 272.31},
      {"long clarinet", clarinet(0.8), 0, 1524.1, 103.64},
      {"saxophone, fundamental", saxophone(), 239, 1296.7, 235.79},
      {"trumpet", trumpet(), 0, 1427.4, 382.01},
      {"trumpet, slack lip", trumpet(220), 0, 555.9, 252.44},
      {"trumpet, tight lip", trumpet(430), 0, 3190.3, 513.01},
      {"trombone", trombone(), 0, 1099.5, 216.72},
      {"voice", voice(), 0, 757.8, 117.64},
      {"syrinx", syrinx(), 0, 248.4, 1052.6},
  };
  for (const ReferenceValue& figure : figures) {
    CAPTURE(figure.name);
    const Parameters& p = figure.instrument;
    const Threshold found =
        LinearStability(p, p.length).threshold(p.reed_frequency, figure.near_hz);
    REQUIRE(found.found);
    CHECK(relative(found.mouth_pressure, figure.pressure) < kQuoted);
    CHECK(relative(found.frequency_hz, figure.frequency) < kQuoted);
  }
}

TEST_CASE("below the threshold a disturbance dies at the rate of the dominant mode") {
  const auto rate = [](const Parameters& p, double pressure) {
    return LinearStability(p, p.length).dominant_mode(pressure, p.reed_frequency).growth_rate;
  };
  CHECK(std::abs(rate(reference::clarinet(), 1300) + 18.7) < 0.05);
  CHECK(std::abs(rate(reference::clarinet(), 1428) + 4.59) < 0.005);
  CHECK(std::abs(rate(reference::clarinet(0.3), 1362) + 12.18) < 0.005);
  CHECK(std::abs(rate(reference::voice(), 720) + 1.88) < 0.005);
}

TEST_CASE("a shut reed leaves the bore ringing alone") {
  const auto check = [](double length, double frequency, double rate) {
    const LinearStability theory(reference::clarinet(length), length);
    CHECK_FALSE(theory.equilibrium(9000, 2500).free);
    const Mode mode = theory.dominant_mode(9000, 2500);
    REQUIRE(mode.found);
    CHECK(std::abs(mode.frequency_hz - frequency) < 0.01);
    CHECK(std::abs(mode.growth_rate - rate) < 0.01);
  };
  check(0.30, 278.25, -22.55);
  check(0.48, 174.30, -17.70);
  check(0.60, 139.43, -15.80);
  check(1.00, 83.46, -12.20);
}

TEST_CASE(
    "without losses and inertia a blown-closed reed starts at a third of its closing pressure") {
  Parameters p = reference::clarinet();
  p.scalar_reflection = 1;
  p.sweep = false;
  p.channel_length = 1e-7;
  p.reed_frequency = 150e3; // stiff and light: quasi-static
  const double closing = 3553.1;
  p.mass = closing * p.width * p.mouth_length / (p.arm_length * std::abs(p.rest_angle)) /
           std::pow(kTwoPi * p.reed_frequency, 2);
  const LinearStability theory(p, p.length);
  CHECK(relative(theory.highest_pressure(p.reed_frequency), closing) < 1e-6);
  const Threshold found = theory.threshold(p.reed_frequency, 178);
  REQUIRE(found.found);
  CHECK(relative(found.mouth_pressure, closing / 3) < 1e-4);
  CHECK(relative(found.frequency_hz, air_at(20).sound_speed / (4 * p.length)) < 1e-3);
}

TEST_CASE("small losses raise the quasi-static threshold by (2/sqrt 27) Re(Y_in) Z_0/zeta") {
  Parameters p = reference::clarinet();
  p.scalar_reflection = 0.99;
  p.sweep = false;
  p.channel_length = 1e-7;
  p.reed_frequency = 150e3;
  const double closing = 3553.1;
  p.mass = closing * p.width * p.mouth_length / (p.arm_length * std::abs(p.rest_angle)) /
           std::pow(kTwoPi * p.reed_frequency, 2);
  const Air air = air_at(p.temperature);
  const double impedance =
      air.density * air.sound_speed / (std::numbers::pi * p.input_radius * p.input_radius);
  const double zeta = impedance * p.width * p.arm_length * std::abs(p.rest_angle) *
                      std::sqrt(2 / (air.density * closing));
  const double admittance = (1 - p.scalar_reflection) / (1 + p.scalar_reflection);
  const double shift = 2 / std::sqrt(27.0) * admittance / zeta;
  const Threshold found = LinearStability(p, p.length).threshold(p.reed_frequency, 178);
  REQUIRE(found.found);
  // First order in the loss: what is left is of second order, and the flow through R_0 < 1 loads
  // the bore with a steady pressure of the same small order.
  CHECK(std::abs(found.mouth_pressure / closing - 1.0 / 3 - shift) < 0.25 * shift);
}

TEST_CASE("no oscillating mode lies to the right of the dominant mode" *
          doctest::skip(kSanitized)) {
  std::mt19937 random(20);
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<>(0, 1)(random));
  };
  const Parameters models[] = {reference::clarinet(), reference::saxophone(), reference::oboe(),
                               reference::trumpet(),  reference::trombone(),  reference::voice(),
                               reference::syrinx()};
  int unstable = 0, missed = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Parameters p = models[trial % 7];
    const double length = between(0.02, 3);
    p.quality = between(1, 30);
    p.flow_length *= between(0.3, 3);
    p.cup_volume = between(1e-8, 1e-5);
    p.wall_loss = between(0.3, 3);
    p.end_radius *= between(0.5, 2);
    const double reed_frequency = p.reed_frequency * between(0.2, 3);
    const LinearStability theory(p, length);
    const double pressure = theory.highest_pressure(reed_frequency) * between(0.02, 0.999);
    const Mode mode = theory.dominant_mode(pressure, reed_frequency);
    const double highest =
        std::max(2 * kTwoPi * reed_frequency, 5 * std::numbers::pi * 343.37 / length);
    CAPTURE(trial);
    CAPTURE(length);
    CAPTURE(reed_frequency);
    CAPTURE(pressure);
    REQUIRE(mode.found);
    CAPTURE(mode.growth_rate);
    CAPTURE(mode.frequency_hz);
    const double margin = 1e-3 + 1e-4 * std::abs(mode.growth_rate);
    if (zeros_right_of(theory, p.quality, pressure, reed_frequency,
                       std::max(0.0, mode.growth_rate) + margin, highest) != 0)
      ++missed;
    if (mode.growth_rate > 2 * margin) {
      ++unstable;
      CHECK(zeros_right_of(theory, p.quality, pressure, reed_frequency, mode.growth_rate - margin,
                           highest) >= 1);
    }
  }
  // A search from a bounded number of points may miss one in some thousand such odd instruments.
  CHECK(missed <= 2);
  CHECK(unstable > 200); // the draw is not vacuous
}

TEST_CASE("a mode solves the characteristic equation") {
  const Parameters p = reference::trumpet();
  const LinearStability theory(p, p.length);
  const Mode mode = theory.dominant_mode(4000, 330);
  const Complex s(mode.growth_rate, kTwoPi * mode.frequency_hz);
  const Complex in = theory.input_admittance(s);
  CHECK(std::abs(in - theory.valve_admittance(s, theory.equilibrium(4000, 330), 330)) <
        1e-7 * std::abs(in));
}

TEST_CASE("the valve rests where the pressures and its spring balance") {
  const auto angle = [](const Parameters& p, double pressure) {
    return LinearStability(p, p.length).equilibrium(pressure, p.reed_frequency);
  };
  const auto check = [&](const Parameters& p, double pressure, double theta, double flow) {
    const Equilibrium e = angle(p, pressure);
    CHECK(e.free);
    CHECK(std::abs(e.displacement / p.arm_length - theta) < 1e-6);
    CHECK(relative(e.flow, flow) < 1e-4);
  };
  check(reference::clarinet(), 700, -0.032899, 1.45798e-4);
  check(reference::trumpet(), 300, 0.013489, 2.40828e-5);
  check(reference::voice(), 300, 0.027388, 8.55706e-5);
}

TEST_CASE("a valve beyond its displacement limit is held and cannot sing") {
  Parameters p = reference::trumpet();
  const LinearStability theory(p, p.length);
  const Equilibrium e = theory.equilibrium(5000, 90);
  CHECK_FALSE(e.free);
  CHECK(e.excess > 0);
  CHECK(e.area == doctest::Approx(p.width * p.displacement_limit));
  CHECK(theory.dominant_mode(5000, 90).growth_rate < 0);
}

TEST_CASE("the linear playing frequency follows the bore") {
  for (const double length : {0.15, 0.3, 0.48, 0.8}) {
    const Parameters p = reference::clarinet(length);
    const double closed_open = 343.37 / (4 * (length + 0.613 * p.end_radius));
    const double f = linear_playing_frequency(p, length, 2500, closed_open);
    // The reed's compliance and swept flow lengthen the bore by 1 to 4 % of a short tube.
    CHECK(f < closed_open);
    CHECK(f > 0.93 * closed_open);
  }
  // With too slack a lip nothing starts, but a pitch is still given.
  const Parameters cylinder = [] {
    Parameters p = reference::trumpet(60);
    p.shape = BoreShape::kCylinder;
    p.length = 0.48;
    p.cup_volume = 0;
    return p;
  }();
  CHECK(linear_playing_frequency(cylinder, 0.48, 60, 175) > 100);
}

TEST_CASE("absurd pressures and frequencies give finite answers") {
  const Parameters p = reference::clarinet();
  const LinearStability theory(p, 0.48);
  for (const double pressure : {0.0, 1e-9, -50.0, -5e4, 5e4})
    for (const double reed : {1.0, 100.0, 18e3}) {
      const Mode mode = theory.dominant_mode(pressure, reed);
      CHECK(std::isfinite(mode.growth_rate));
      CHECK(std::isfinite(mode.frequency_hz));
    }
}

} // namespace
} // namespace tactus::reed

#include "core/reed/brass.hpp"

#include "core/reed/linear_stability.hpp"
#include "core/reed/presets.hpp"
#include "tests/core/reed/bell_reference.hpp"
#include "tests/core/reed/bore_echo.hpp"
#include "tests/core/reed/render.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

// Trumpet and trombone: the bell's filters against the horn equation
// (bench/reed_bores/bell_reference.py), and what valves and slide make of the tube.

namespace tactus::reed {
namespace {

using namespace test;
constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr BoreEnd kBells[] = {BoreEnd::kTrumpet, BoreEnd::kTrombone};

Parameters brass(BoreEnd end) {
  Parameters p = find_preset(end == BoreEnd::kTrumpet ? "trumpet" : "trombone").value();
  p.tune = p.tube = true;
  p.end = end;
  return p;
}

const Termination& bell_of(BoreEnd end) { return bells(end).front(); }

} // namespace

TEST_CASE("tubes with a bell resonate where the horn equation says, and as high" *
          doctest::skip(kSanitized)) {
  double worst_cents = 0, worst_db = 0;
  for (const BellReference& reference : kBellReference)
    for (const double rate : {44100.0, 48000.0, 96000.0}) {
      Parameters p = with_tube(brass(reference.end));
      p.cup_volume = 0; // the reference has none
      const auto echo = echo_of(p, bell_of(reference.end), reference.length, rate,
                                static_cast<std::size_t>(0.5 * rate));
      for (const auto& peak : reference.peaks) {
        if (!(peak.hz > 0))
          continue;
        const auto [at, high_db] = peak_near(p, echo, rate, peak.hz);
        CAPTURE(static_cast<int>(reference.end));
        CAPTURE(reference.length);
        CAPTURE(rate);
        CAPTURE(peak.hz);
        worst_cents = std::max(worst_cents, std::abs(cents(at, peak.hz)));
        worst_db = std::max(worst_db, std::abs(high_db - peak.level));
        CHECK(std::abs(cents(at, peak.hz)) < 5);
        CHECK(std::abs(high_db - peak.level) < 1);
      }
    }
  MESSAGE("worst: " << worst_cents << " cents, " << worst_db << " dB");
}

TEST_CASE("no bell reflects more than arrives, at any frequency and rate") {
  for (const BoreEnd end : kBells) {
    const Termination& one = bell_of(end);
    CHECK(bells(end).size() == 1);
    CHECK(std::abs(one.reflectance(0.0).value + 1.0) < 0.01);
    for (double hz = 0.01; hz < 1e6; hz *= 1.001)
      REQUIRE(std::abs(one.reflectance({0, kTwoPi * hz}).value) <= 1 + 1e-9);
    for (const double rate : {8000.0, 48000.0, 192000.0}) {
      DigitalReflection digital;
      digital.set(one.reflection, one.at_zero, rate, 1.03, 1);
      for (int i = 0; i <= 2048; ++i)
        REQUIRE(std::abs(digital.at(std::polar(1.0, std::numbers::pi * i / 2048))) <= 1 + 1e-9);
    }
  }
}

} // namespace tactus::reed

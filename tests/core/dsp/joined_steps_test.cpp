#include "core/dsp/joined_steps.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

// A hand's position by its readings, as straight lines.

using namespace tactus;

namespace {

constexpr double kRate = 48000;

/// The hand's position at each sample, read every so many.
template <class Position>
std::vector<float> joined(Position position, std::size_t every, double seconds) {
  std::vector<float> x(static_cast<std::size_t>(seconds * kRate));
  for (std::size_t n = 0; n < x.size(); ++n)
    x[n] = static_cast<float>(position(static_cast<double>(n / every * every) / kRate));
  JoinedSteps steps;
  steps.prepare(kRate);
  steps.run(x);
  return x;
}

double fastest(const std::vector<float>& x) {
  float largest = 0;
  for (std::size_t n = 1; n < x.size(); ++n)
    largest = std::max(largest, std::abs(x[n] - x[n - 1]));
  return largest * kRate;
}

} // namespace

TEST_CASE("a hand that moves off from rest is nowhere faster than it is, late by two readings") {
  for (const double rest : {0.2, 0.02}) // s; longer and shorter than what counts as rest
    for (const std::size_t every : {std::size_t{48}, std::size_t{384}})
      for (const double speed : {0.1, 1.0}) {
        const auto hand = [&](double t) {
          return .004 - speed * std::clamp(t - rest, 0.0, .05 / speed);
        };
        const std::vector<float> x = joined(hand, every, 1);
        CAPTURE(rest);
        CAPTURE(every);
        CAPTURE(speed);
        CHECK(fastest(x) < 1.003 * speed); // of single precision
        for (std::size_t n = static_cast<std::size_t>((rest + .06) * kRate); n < x.size(); ++n) {
          const double t = static_cast<double>(n) / kRate,
                       late = 3 * static_cast<double>(every) / kRate;
          REQUIRE(x[n] <= hand(t - late) + 1e-6);
          REQUIRE(x[n] >= hand(t) - 1e-6);
        }
        CHECK(x.back() == static_cast<float>(hand(1)));
      }
}

TEST_CASE("a hand that swings, slows and turns is followed to two readings, no faster than it is") {
  const auto hand = [](double t) { return .01 * std::sin(40 * t) * std::min(t, 1.0); };
  for (const std::size_t every : {std::size_t{1}, std::size_t{48}}) {
    const std::vector<float> x = joined(hand, every, 2);
    CAPTURE(every);
    CHECK(fastest(x) < 1.003 * .4);
    const double late = 2.1 * static_cast<double>(every) / kRate; // times the largest speed
    for (std::size_t n = 4800; n < x.size(); ++n)
      REQUIRE(std::abs(x[n] - hand(static_cast<double>(n) / kRate)) < .42 * late + 1e-6);
  }
}

#include "core/contact/strike_scatter.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <numbers>

// A hand's strikes against the normal law they are drawn from.

using namespace tactus;
using contact::StrikeScatter;

namespace {

/// Mean and standard deviation of what a function makes of many strikes.
struct Spread {
  double mean = 0, deviation = 0;
};
template <class Of> Spread spread(double variation, double extent_m, Of of) {
  constexpr int kStrikes = 20000;
  Random random(7);
  double sum = 0, squares = 0;
  for (int i = 0; i < kStrikes; ++i) {
    const double x = of(StrikeScatter::draw(variation, extent_m, random));
    sum += x;
    squares += x * x;
  }
  const double mean = sum / kStrikes;
  return {mean, std::sqrt(squares / kStrikes - mean * mean)};
}

// Of a normal number cut at twice its deviation: var = 1 - 4 phi(2) / (2 Phi(2) - 1).
const double kCut =
    std::sqrt(1 - 4 * std::exp(-2.0) / std::sqrt(2 * std::numbers::pi) / std::erf(std::sqrt(2.0)));

} // namespace

TEST_CASE("strikes scatter about what was meant, in proportion to the variation") {
  for (const double variation : {0.25, 1.0}) {
    CAPTURE(variation);
    const auto check = [&](double deviation, double extent_m, auto of) {
      const Spread found = spread(variation, extent_m, of);
      const double expected = variation * kCut * deviation;
      CHECK(std::abs(found.mean) < 0.03 * expected); // 4 standard errors
      CHECK(found.deviation == doctest::Approx(expected).epsilon(0.02));
    };
    check(0.12, 0.2, [](const StrikeScatter& s) { return std::log(s.speed_factor); });
    for (const std::size_t axis : {std::size_t{0}, std::size_t{1}}) {
      check(4 * std::numbers::pi / 180, 0.2,
            [&](const StrikeScatter& s) { return s.tilt_rad[axis]; });
      check(0.005, 0.2, [&](const StrikeScatter& s) { return s.offset_m[axis]; });
      check(0.008, 5, [&](const StrikeScatter& s) { return s.offset_m[axis]; });
    }
  }
}

TEST_CASE("no strike goes further astray than twice the spread") {
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const auto s = StrikeScatter::draw(1, 1, random);
    CHECK(std::abs(std::log(s.speed_factor)) <= 0.24 + 1e-12);
    CHECK(std::abs(s.tilt_rad[0]) <= 8.01 * std::numbers::pi / 180);
    CHECK(std::abs(s.offset_m[1]) <= 0.016 + 1e-12);
  }
}

#include "core/reed/playability/gradient_field.hpp"
#include "core/reed/playability/gradient_plane.hpp"
#include "core/reed/playability/growth_map.hpp"

#include "tests/core/reed/playability/five_reeds.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace tactus::reed {
namespace {

using test::trumpet_map;
constexpr ControlRange kTrumpetRange{0, 8000, 80, 900};
constexpr ControlRange kClarinetRange{0, 5000, 1000, 3500};

TEST_CASE("the plane's corners are the ends of the ranges, its middle the interval's middle") {
  CHECK(kTrumpetRange.pressure(0) == 0);
  CHECK(kTrumpetRange.pressure(1) == 8000);
  CHECK(kTrumpetRange.frequency(0) == 80);
  CHECK(std::abs(kTrumpetRange.frequency(1) - 900) < 1e-9);
  CHECK(std::abs(kTrumpetRange.frequency(0.5) - std::sqrt(80.0 * 900.0)) < 1e-9);
}

TEST_CASE(
    "central differences are exact for a plane, and err by delta^2/6 of the third derivative") {
  const auto gradient_of = [](const GradientStencil& stencil, const auto& f) {
    std::array<double, 5> values{};
    for (std::size_t i = 0; i < 5; ++i)
      values[i] = f(stencil.y[i], stencil.z[i]);
    return stencil.gradient(values);
  };
  for (const double y : {0.0, 0.003, 0.4, 0.995, 1.0})
    for (const double z : {0.0, 0.007, 0.6, 1.0}) {
      const Gradient g = gradient_of(
          {y, z, 0.01}, [](double at_y, double at_z) { return 0.3 - 1.7 * at_y + 2.9 * at_z; });
      CHECK(std::abs(g.y + 1.7) < 1e-12);
      CHECK(std::abs(g.z - 2.9) < 1e-12);
    }
  for (const double delta : {0.04, 0.02, 0.01}) {
    const Gradient g = gradient_of({0.5, 0.5, delta},
                                   [](double y, double z) { return std::pow(y, 3) + std::exp(z); });
    CHECK(std::abs(g.y - 0.75 - delta * delta) < 1e-12);
    CHECK(std::abs((g.z - std::exp(0.5)) / (std::exp(0.5) * delta * delta / 6) - 1) < 1e-3);
  }
}

TEST_CASE("a hand outside the plane, or nowhere, is held at the edge") {
  const GradientStencil outside(1.7, -3, 0.01);
  CHECK(outside.y[0] == 1);
  CHECK(outside.z[0] == 0);
  const GradientStencil nowhere(std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::infinity(), 0.01);
  CHECK(nowhere.y[0] == 0);
  CHECK(nowhere.z[0] == 1);
}

TEST_CASE("an instrument's own range holds its notes") {
  for (const Parameters& p :
       {reference::clarinet(), reference::saxophone(), reference::oboe(), reference::trumpet(),
        reference::trombone(), reference::voice(), reference::syrinx()}) {
    const ControlRange range = range_for(p);
    const LinearStability theory(p, p.length);
    CHECK(range.lowest_frequency < p.reed_frequency);
    CHECK(range.highest_frequency > p.reed_frequency);
    const Threshold threshold = theory.threshold(p.reed_frequency);
    CHECK(threshold.mouth_pressure > 0.1 * range.highest_pressure);
    CHECK(threshold.mouth_pressure < 0.5 * range.highest_pressure);
  }
}

GrowthMap map_of(const Parameters& p, const ControlRange& range, std::size_t nodes,
                 std::size_t step = 10000) {
  GrowthMap map;
  map.prepare(nodes, nodes);
  map.begin({p, p.length}, range);
  CHECK_FALSE(map.ready());
  while (!map.advance(step))
    CHECK(map.progress() < 1);
  return map;
}

TEST_CASE("a growth map does not depend on the portions in which it was made") {
  const Parameters p = reference::trumpet();
  const GrowthMap whole = map_of(p, kTrumpetRange, 11), pieces = map_of(p, kTrumpetRange, 11, 7);
  for (std::size_t k = 0; k < 11; ++k)
    for (std::size_t i = 0; i < 11; ++i)
      REQUIRE(whole.height().node(i, k) == pieces.height().node(i, k));
}

TEST_CASE("a field's values and slopes are exact for a bilinear quantity, clamped to the plane") {
  const auto f = [](double y, double z) { return 2 + 3 * y - 5 * z + 4 * y * z; };
  GradientField field;
  CHECK(field.empty());
  CHECK(field.value(.5, .5) == 0);
  CHECK(field.gradient(.5, .5).y == 0);
  field.resize(1, 0);
  CHECK(field.columns() == 2); // at least two of each
  CHECK(field.rows() == 2);
  field.resize(6, 9);
  for (std::size_t k = 0; k < 9; ++k)
    for (std::size_t i = 0; i < 6; ++i)
      field.node(i, k) = f(field.y_of(i), field.z_of(k));
  field.differentiate();
  for (int i = -2; i <= 22; ++i)
    for (int k = -2; k <= 22; ++k) {
      const double y = i / 20., z = k / 20.;
      const double held_y = std::clamp(y, 0., 1.), held_z = std::clamp(z, 0., 1.);
      CHECK(field.value(y, z) == doctest::Approx(f(held_y, held_z)));
      CHECK(field.gradient(y, z).y == doctest::Approx(3 + 4 * held_z));
      CHECK(field.gradient(y, z).z == doctest::Approx(-5 + 4 * held_y));
    }
  CHECK(field.value(NAN, 1) == doctest::Approx(f(0, 1)));
  CHECK(field.value(9, NAN) == field.value(1, 0));
  // Inside, a node's slope is that between its neighbours; at the edge, to its only one.
  const auto square = [](double y) { return y * y; };
  for (std::size_t k = 0; k < 9; ++k)
    for (std::size_t i = 0; i < 6; ++i)
      field.node(i, k) = square(field.y_of(i));
  field.differentiate();
  CHECK(field.gradient(.4, .3).y == doctest::Approx(.8));
  CHECK(field.gradient(0, .3).y == doctest::Approx(.2));
  CHECK(field.gradient(1, .3).y == doctest::Approx(1.8));
  CHECK(field.gradient(.5, .3).y == doctest::Approx(1)); // between .8 and 1.2
  CHECK(std::abs(field.gradient(.5, .3).z) < 1e-12);
}

TEST_CASE("a growth map's slopes are those of its own values, for the growth and for the height") {
  const GrowthMap& map = trumpet_map();
  for (const GradientField* field : {&map.growth(), &map.height()}) {
    GradientField again;
    again.resize(41, 41);
    for (std::size_t k = 0; k < 41; ++k)
      for (std::size_t i = 0; i < 41; ++i)
        again.node(i, k) = field->node(i, k);
    again.differentiate();
    double steepest = 0;
    for (int n = 0; n < 300; ++n) {
      const double y = std::fmod(.37 * n, 1.), z = std::fmod(.61 * n, 1.);
      CHECK(field->gradient(y, z).y == again.gradient(y, z).y);
      CHECK(field->gradient(y, z).z == again.gradient(y, z).z);
      steepest = std::max(steepest, std::abs(field->gradient(y, z).y));
    }
    CHECK(steepest > 0);
  }
}

/// Share of silent points from where climbing the height leads to a note.
double arrivals(const GrowthMap& map, const Parameters& p, const ControlRange& range, int points) {
  const LinearStability theory(p, p.length);
  const auto sounds = [&](double y, double z) {
    const double pressure = range.pressure(y), frequency = range.frequency(z);
    return theory.equilibrium(pressure, frequency).free &&
           theory.dominant_mode(pressure, frequency).growth_rate > 0;
  };
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(0, 1);
  int silent = 0, arrived = 0;
  while (silent < points) {
    double y = uniform(random), z = uniform(random);
    if (sounds(y, z))
      continue;
    ++silent;
    for (int step = 0; step < 200 && !sounds(y, z); ++step) {
      const Gradient g = map.height().gradient(y, z);
      const double size = std::hypot(g.y, g.z);
      if (!(size > 0))
        break;
      y = std::clamp(y + 0.01 * g.y / size, 0.0, 1.0);
      z = std::clamp(z + 0.01 * g.z / size, 0.0, 1.0);
    }
    arrived += sounds(y, z);
  }
  return static_cast<double>(arrived) / silent;
}

TEST_CASE("climbing the height leads from silence to a note") {
  CHECK(arrivals(trumpet_map(), reference::trumpet(), kTrumpetRange, 30) > 0.9);
}

TEST_CASE("climbing the height leads from nearly everywhere in silence to a note" *
          doctest::test_suite("slow")) {
  const Parameters p = reference::clarinet();
  CHECK(arrivals(trumpet_map(), reference::trumpet(), kTrumpetRange, 300) > 0.97);
  CHECK(arrivals(map_of(p, kClarinetRange, 41), p, kClarinetRange, 300) > 0.97);
}

} // namespace
} // namespace tactus::reed

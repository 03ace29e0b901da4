#include "core/reed/playability/playability_map.hpp"

#include "core/reed/playability/linear_stability.hpp"
#include "core/reed/playability/playability.hpp"
#include "tests/core/reed/reference_instruments.hpp"
#include "tests/core/reed/reference_transform.hpp"
#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace tactus::reed {
namespace {

using namespace test;

PlayabilityMapSettings trumpet_settings() {
  PlayabilityMapSettings s;
  s.parameters = reference::trumpet();
  s.range = {0, 8000, 80, 900};
  return s;
}

PlayabilityMap map_of(const PlayabilityMapSettings& settings, std::size_t columns,
                      std::size_t rows) {
  PlayabilityMap map;
  map.begin(settings, columns, rows);
  for (std::size_t n = 0; n < map.size();)
    n = map.advance(n);
  return map;
}

TEST_CASE("a node's value depends on its position alone, not on the nodes computed with it") {
  const PlayabilityMap whole = map_of(trumpet_settings(), 5, 5);
  PlayabilityMap again;
  again.begin(trumpet_settings(), 5, 5);
  for (std::size_t n : {24u, 11u, 3u, 0u}) { // the other seven lanes hold other nodes than before
    again.advance(n);
    CHECK(again.field().node(n % 5, n / 5) == whole.field().node(n % 5, n / 5));
  }
}

TEST_CASE("a node is the playability of the instrument played there from rest") {
  const PlayabilityMapSettings s = trumpet_settings();
  const PlayabilityMap map = map_of(s, 11, 11);
  for (const auto& [i, k] : {std::pair{4u, 3u}, {6u, 5u}, {9u, 8u}, {6u, 8u}}) {
    Instrument instrument = make_instrument(s.parameters);
    PlayabilityFollower<double> estimator;
    estimator.prepare(48000);
    const Recording r = play(instrument, ramp(s.range.pressure(map.field().y_of(i)), 0.7, 48000),
                             48000, s.range.frequency(map.field().z_of(k)));
    double sum = 0;
    int measurements = 0;
    for (std::size_t n = 0; n < r.theta.size(); ++n) {
      estimator.tick(r.theta[n]);
      if (n < 24000 || n % 64 != 63)
        continue;
      sum += estimator.playability();
      ++measurements;
    }
    // The map computes in single precision and reads f_p at other samples of the listening time.
    CHECK(std::abs(map.field().node(i, k) - sum / measurements) < 5e-3);
  }
}

/// Of a map of nodes x nodes, with so long to speak: theory and sound agree on so many nodes.
void check_theory(std::size_t nodes, double settle_s, double slowest, double share) {
  PlayabilityMapSettings s = trumpet_settings();
  s.settle_s = settle_s;
  const PlayabilityMap map = map_of(s, nodes, nodes);
  const LinearStability theory(s.parameters, s.parameters.length);
  int agree = 0, decided = 0;
  for (std::size_t k = 0; k < nodes; ++k)
    for (std::size_t i = 0; i < nodes; ++i) {
      const double pressure = s.range.pressure(map.field().y_of(i));
      const double lip = s.range.frequency(map.field().z_of(k));
      const double rate = theory.dominant_mode(pressure, lip).growth_rate;
      const bool free = theory.equilibrium(pressure, lip).free;
      if (free && std::abs(rate) < slowest)
        continue; // too slow to be decided within the time
      ++decided;
      agree += (map.field().node(i, k) > 0.02) == (free && rate > 0);
    }
  CHECK(decided > 0.85 * static_cast<double>(nodes * nodes));
  CHECK(agree >= share * decided);
}

TEST_CASE("linear theory predicts where a trumpet sounds") { check_theory(9, 0.5, 5, 0.95); }

TEST_CASE("linear theory predicts where a trumpet sounds, all but one node in a hundred" *
          doctest::test_suite("slow")) {
  check_theory(31, 1.8, 3, 0.99);
}

/// Regime at the end, and mean periodicity of the last 60 %, of an instrument steadily blown.
struct Measurement {
  Regime regime;
  double periodicity;
};
Measurement measure(const Parameters& p, double pressure, double rate, double seconds) {
  const Recording r = play(p, pressure, seconds, rate);
  Playability estimator;
  estimator.prepare(rate, std::make_shared<reference::RadixTwo>());
  double sum = 0;
  std::size_t frames = 0, before = 0;
  for (std::size_t n = 0; n < r.theta.size(); ++n) {
    estimator.tick(r.theta[n]);
    if (estimator.frames() == before)
      continue;
    before = estimator.frames();
    if (static_cast<double>(n) < 0.4 * seconds * rate)
      continue;
    sum += estimator.periodicity().periodicity;
    ++frames;
  }
  return {estimator.regime(), sum / static_cast<double>(frames)};
}

void check_regimes(double rate, double seconds) {
  Parameters chaotic = reference::syrinx();
  chaotic.reed_frequency = 1670;
  chaotic.quality = 22.8;
  chaotic.mass = 2.4e-7;
  chaotic.rest_angle = 0.0514;
  chaotic.flow_length = 3.5e-3;
  chaotic.oversampling = 4;
  CAPTURE(rate);
  const Measurement clarinet = measure(reference::clarinet(), 2000, rate, seconds);
  CHECK(clarinet.regime == Regime::kPeriodic);
  CHECK(clarinet.periodicity > 0.985);
  const Measurement trumpet = measure(reference::trumpet(235), 6000, rate, seconds);
  CHECK(trumpet.regime == Regime::kQuasiPeriodic);
  CHECK(std::abs(trumpet.periodicity - 0.96) < 0.02);
  const Measurement syrinx = measure(chaotic, 3700, rate, seconds);
  CHECK(syrinx.regime == Regime::kChaotic);
  CHECK(syrinx.periodicity < 0.35); // chaos: the value differs between sample rates
}

TEST_CASE("a clarinet is periodic, a slack trumpet quasi-periodic, an overblown syrinx chaotic") {
  check_regimes(48000, 1);
}

TEST_CASE("a clarinet is periodic, a slack trumpet not quite, a syrinx chaotic at any rate" *
          doctest::test_suite("slow")) {
  for (const double rate : {44100.0, 48000.0, 96000.0})
    check_regimes(rate, 2.5);
}

} // namespace
} // namespace tactus::reed

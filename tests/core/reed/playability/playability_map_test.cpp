#include "core/reed/playability/playability_map.hpp"

#include "core/reed/instrument/instrument.hpp"
#include "core/reed/playability/linear_stability.hpp"
#include "core/reed/playability/playability.hpp"
#include "tests/core/reed/reference_instruments.hpp"
#include "tests/core/reed/reference_transform.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace tactus::reed {
namespace {

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
  PlayabilityMap whole = map_of(trumpet_settings(), 9, 9), again;
  again.begin(trumpet_settings(), 9, 9);
  for (std::size_t n = 80;; n = n > 13 ? n - 13 : 0) {
    again.advance(n);
    const double value = again.field().node(n % 9, n / 9);
    // The other seven lanes hold other nodes than in `whole`.
    CHECK(value == whole.field().node(n % 9, n / 9));
    if (n == 0)
      break;
  }
}

TEST_CASE("a node is the playability of the instrument played there from rest") {
  const PlayabilityMapSettings s = trumpet_settings();
  const PlayabilityMap map = map_of(s, 11, 11);
  for (const std::size_t i : {4u, 6u, 9u})
    for (const std::size_t k : {3u, 5u, 8u}) {
      const double pressure = s.range.pressure(map.field().y_of(i));
      const double lip = s.range.frequency(map.field().z_of(k));
      Instrument instrument;
      instrument.set(s.parameters);
      instrument.prepare(48000, 64);
      PlayabilityFollower<double> estimator;
      estimator.prepare(48000);
      double sum = 0;
      int measurement = 0;
      for (int n = 0; n < 33600; ++n) {
        const double mouth = pressure * std::min(1.0, (n + 1) / 960.0);
        const double bore = 0;
        double out[4];
        const auto one = [](double& x) { return std::span(&x, 1); };
        instrument.process<double>({std::span(&mouth, 1), std::span(&lip, 1), std::span(&bore, 1)},
                                   {one(out[0]), one(out[1]), one(out[2]), one(out[3])});
        estimator.tick(out[1]);
        if (n < 24000 || n % 64 != 63)
          continue;
        sum += estimator.playability();
        ++measurement;
      }
      // The map computes in single precision and reads f_p at other samples of the listening time.
      CHECK(std::abs(map.field().node(i, k) - sum / measurement) < 5e-3);
    }
}

TEST_CASE("linear theory predicts where a trumpet sounds" * doctest::skip(kSanitized)) {
  PlayabilityMapSettings s = trumpet_settings();
  s.settle_s = 1.8;
  const PlayabilityMap map = map_of(s, 31, 31);
  const LinearStability theory(s.parameters, s.parameters.length);
  int agree = 0, decided = 0;
  for (std::size_t k = 0; k < 31; ++k)
    for (std::size_t i = 0; i < 31; ++i) {
      const double pressure = s.range.pressure(map.field().y_of(i));
      const double lip = s.range.frequency(map.field().z_of(k));
      const double rate = theory.dominant_mode(pressure, lip).growth_rate;
      const bool free = theory.equilibrium(pressure, lip).free;
      if (free && std::abs(rate) < 3)
        continue; // too slow to be decided within the time
      ++decided;
      if ((map.field().node(i, k) > 0.02) == (free && rate > 0))
        ++agree;
    }
  CHECK(decided > 850);
  CHECK(agree >= 0.99 * decided);
}

/// Regime at the end, and mean periodicity from 1 to 2.5 s, of an instrument at a steady pressure.
struct Measurement {
  Regime regime;
  double periodicity;
};
Measurement measure(const Parameters& p, double pressure, double rate) {
  Instrument instrument;
  instrument.set(p);
  instrument.prepare(rate, 64);
  Playability estimator;
  estimator.prepare(rate, std::make_shared<reference::RadixTwo>());
  std::vector<double> mouth(64), reed(64, 0.0), bore(64, 0.0), sound(64), angle(64), pb(64), u(64);
  double sum = 0;
  std::size_t frames = 0, before = 0;
  for (std::size_t n = 0; n < static_cast<std::size_t>(2.5 * rate); n += 64) {
    for (std::size_t i = 0; i < 64; ++i)
      mouth[i] = pressure * std::min(1.0, static_cast<double>(n + i + 1) / (0.02 * rate));
    instrument.process<double>({mouth, reed, bore}, {sound, angle, pb, u});
    for (const double x : angle)
      estimator.tick(x);
    if (estimator.frames() == before)
      continue;
    before = estimator.frames();
    if (static_cast<double>(n) < rate)
      continue;
    sum += estimator.periodicity().periodicity;
    ++frames;
  }
  return {estimator.regime(), sum / static_cast<double>(frames)};
}

TEST_CASE("a clarinet is periodic, a slack trumpet quasi-periodic, an overblown syrinx chaotic" *
          doctest::skip(kSanitized)) {
  Parameters chaotic = reference::syrinx();
  chaotic.reed_frequency = 1670;
  chaotic.quality = 22.8;
  chaotic.mass = 2.4e-7;
  chaotic.rest_angle = 0.0514;
  chaotic.flow_length = 3.5e-3;
  chaotic.oversampling = 4;
  for (const double rate : {44100.0, 48000.0, 96000.0}) {
    CAPTURE(rate);
    const Measurement clarinet = measure(reference::clarinet(), 2000, rate);
    CHECK(clarinet.regime == Regime::kPeriodic);
    CHECK(clarinet.periodicity > 0.985);
    const Measurement trumpet = measure(reference::trumpet(235), 6000, rate);
    CHECK(trumpet.regime == Regime::kQuasiPeriodic);
    CHECK(std::abs(trumpet.periodicity - 0.96) < 0.02);
    const Measurement syrinx = measure(chaotic, 3700, rate);
    CHECK(syrinx.regime == Regime::kChaotic);
    CHECK(syrinx.periodicity < 0.35); // chaos: the value differs between sample rates
  }
}

} // namespace
} // namespace tactus::reed

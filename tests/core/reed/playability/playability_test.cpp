#include "core/reed/playability/playability.hpp"

#include "tests/core/reed/reference_transform.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

namespace tactus::reed {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRates[] = {44100, 48000, 96000};

std::shared_ptr<RealTransform> transform() { return std::make_shared<reference::RadixTwo>(); }

/// A follower that has seen a signal.
class Fed {
public:
  explicit Fed(const PlayabilityParameters& p = {}, double rate = 48000) : rate_(rate) {
    follower.set(p);
    follower.prepare(rate);
  }
  template <class Signal> void feed(double seconds, const Signal& signal) {
    for (int n = 0; n < static_cast<int>(seconds * rate_); ++n)
      follower.tick(signal(n / rate_));
  }
  PlayabilityFollower<double> follower;

private:
  double rate_;
};

double sine(double frequency, double t) { return std::sin(2 * kPi * frequency * t); }

auto tone(double amplitude, double frequency) {
  return [=](double t) { return amplitude * sine(frequency, t); };
}

TEST_CASE("the envelope of a sine is 2/pi of its amplitude, and a crossing counts once a period") {
  PlayabilityParameters p;
  p.attack_s = p.release_s = 0.1; // it rises as slowly as it falls
  for (const double rate : kRates)
    for (const double frequency : {87.0, 440.0, 1600.0}) {
      Fed fed(p, rate);
      fed.feed(1.2, [&](double t) { return -0.04 + 0.02 * sine(frequency, t); });
      CHECK(std::abs(fed.follower.envelope() / (0.02 * 2 / kPi) - 1) < 0.01);
      CHECK(std::abs(fed.follower.crossing_rate() - frequency) <= 1 / 0.05);
    }
}

TEST_CASE("envelope, crossings and jump are their definitions, sample by sample") {
  // docs/theory/playability.md, computed from the whole history at each time of the request.
  for (const double rate : {8000.0, 48000.0})
    for (const bool slow_attack : {false, true}) {
      PlayabilityParameters p;
      p.attack_s = slow_attack ? 60e-3 : 4e-3;
      p.release_s = slow_attack ? 10e-3 : 70e-3;
      p.highpass_hz = 20;
      p.window_s = 30e-3;
      p.hysteresis = 0.3;
      p.reference_rad = 0.02;
      PlayabilityFollower<double> follower;
      follower.set(p);
      follower.prepare(rate);
      const double hop = std::round(rate * 0.5e-3), window = std::round(p.window_s * rate / hop);
      const double pole = std::exp(-2 * kPi * p.highpass_hz / rate);
      double before = 0, high = 0, y = 0;
      bool armed = false;
      std::vector<int> crossings;
      std::mt19937 random(3);
      std::normal_distribution<double> noise(0, 0.004);
      const int count = static_cast<int>(rate);
      double highest = 0;
      for (int n = 0; n < count; ++n) {
        // A note, a softer one, its pitch rising by more than an octave, and noise alone.
        const double t = n / rate, louder = t < 0.4 ? 1 : 0.2, tone = t < 0.9 ? 0.03 : 0;
        const double angle = 0.01 + louder * (tone * sine(t < 0.6 ? 150 : 380, t) + noise(random));
        follower.tick(angle);
        high = n == 0 ? 0 : angle - before + pole * high;
        before = angle;
        const double size = std::abs(high);
        const double v = std::exp(-1 / ((size > y ? p.attack_s : p.release_s) * rate));
        y = (1 - v) * size + v * y;
        if (high < -p.hysteresis * y - 1e-9)
          armed = true;
        if (armed && high > p.hysteresis * y + 1e-9) {
          armed = false;
          crossings.push_back(n);
        }
        REQUIRE(follower.envelope() == doctest::Approx(y).epsilon(1e-9));
        if ((n + 1) % static_cast<int>(hop) != 0)
          continue;
        const auto counted = std::count_if(crossings.begin(), crossings.end(),
                                           [&](int at) { return at > n - window * hop; });
        REQUIRE(follower.crossing_rate() ==
                doctest::Approx(static_cast<double>(counted) * rate / (window * hop)));
        // A (1 - max(J, H)).
        const double many = std::clamp((follower.crossing_rate() - 4000) / 2000, 0.0, 1.0);
        highest = std::max(highest, many);
        REQUIRE(follower.playability() ==
                doctest::Approx(y / (y + p.reference_rad) * (1 - std::max(follower.jump(), many))));
      }
      CHECK(crossings.size() > 80);
      CHECK((highest > 0.5) == (rate > 20000));
    }
}

TEST_CASE("a valve that only rises has not crossed, and reset forgets") {
  Fed fed;
  fed.feed(0.02, [](double t) { return t < 0.01 ? 0.0 : 0.05; });
  CHECK(fed.follower.crossing_rate() == 0);
  fed.feed(0.2, tone(0.05, 300));
  CHECK(fed.follower.crossing_rate() > 0);
  fed.follower.reset();
  CHECK(fed.follower.crossing_rate() == 0);
  CHECK(fed.follower.envelope() == 0);
  CHECK(fed.follower.jump() == 0);
  CHECK(fed.follower.playability() == 0);
}

TEST_CASE("the jump is (z/z_mean - 1.5)/1.5 between 1.5 and 3 times the mean, and passes") {
  for (const double ratio : {1.4, 2.0, 2.6, 3.2}) {
    Fed fed;
    fed.feed(2, tone(0.05, 200));
    const double before = fed.follower.playability();
    CHECK(fed.follower.jump() == 0);
    fed.feed(0.0505, tone(0.05, 200 * ratio));
    // A window of 50 ms after the change the mean of 0.5 s has followed by a twentieth.
    const double mean = 1 + (ratio - 1) * 0.05;
    CHECK(fed.follower.jump() ==
          doctest::Approx(std::clamp((ratio / mean - 1.5) / 1.5, 0.0, 1.0)).epsilon(0.02).scale(1));
    if (ratio > 3)
      CHECK(fed.follower.playability() < 0.2 * before);
    fed.feed(2, tone(0.05, 200 * ratio));
    CHECK(fed.follower.jump() == 0); // the new rate has become the usual one
  }
}

TEST_CASE("in the robust mode aperiodicity takes by a smooth step from 0.04 to 0.25") {
  Fed fed;
  PlayabilityParameters p;
  p.mode = PlayabilityParameters::Mode::kRobust;
  fed.follower.set(p);
  fed.feed(1, tone(0.05, 200));
  const double y = fed.follower.envelope(), whole = y / (y + p.reference_rad);
  REQUIRE(fed.follower.jump() == 0);
  for (const double a : {0.0, 0.04, 0.08, 0.145, 0.2, 0.25, 1.0}) {
    const double t = std::clamp((a - 0.04) / 0.21, 0.0, 1.0);
    CHECK(fed.follower.playability(0, a) == doctest::Approx(whole * (1 - t * t * (3 - 2 * t))));
  }
  p.mode = PlayabilityParameters::Mode::kPaper;
  fed.follower.set(p);
  CHECK(fed.follower.playability(0, 1.0) == doctest::Approx(whole));
}

TEST_CASE("a bent valve that stands still does not play") {
  Fed fed;
  fed.follower.tick(-0.04);
  CHECK(fed.follower.envelope() == 0);
  fed.feed(1, [](double) { return 0.03; });
  CHECK(fed.follower.envelope() < 1e-3 * 0.07);
  CHECK(fed.follower.playability() < 0.01);
  fed.feed(10, [](double) { return 0.03; });
  CHECK(fed.follower.envelope() == 0); // and costs no denormal arithmetic
}

TEST_CASE("the start of a note is no jump") {
  Fed fed;
  for (int note = 0; note < 3; ++note) {
    fed.feed(1, [](double) { return 0.0; });
    fed.feed(0.5, [&](double t) {
      CHECK(fed.follower.jump() == 0);
      return 0.05 * sine(330, t);
    });
  }
}

TEST_CASE("the variation of the intervals is that of two alternating periods") {
  PlayabilityParameters p;
  p.highpass_hz = 0.1;
  Fed fed(p);
  // Periods of 240 and 160 samples in turn: deviation 40 about a mean of 200. The level that marks
  // a crossing rides on the envelope, which moves the marks by a few samples.
  for (int pair = 0; pair < 100; ++pair)
    for (const int period : {240, 160})
      for (int n = 0; n < period; ++n)
        fed.follower.tick(0.05 * std::sin(2 * kPi * n / period));
  CHECK(std::abs(fed.follower.interval_variation() - 0.2) < 0.02);
  fed.feed(1, tone(0.05, 240));
  CHECK(fed.follower.interval_variation() < 1e-3);
  fed.feed(1, [](double) { return 0.0; });
  CHECK(fed.follower.interval_variation() == 0);
}

/// YIN's normalised difference straight from its definition.
Periodicity by_definition(const std::vector<double>& x, double rate) {
  const std::size_t half = x.size() / 2;
  std::vector<double> d(half, 1);
  double sum = 0;
  for (std::size_t lag = 1; lag < half; ++lag) {
    double difference = 0;
    for (std::size_t j = 0; j < half; ++j)
      difference += std::pow(x[j] - x[j + lag], 2);
    sum += difference;
    d[lag] = difference * static_cast<double>(lag) / sum;
  }
  std::size_t best = 2;
  for (std::size_t lag = 2; lag + 1 < half; ++lag) {
    if (d[lag] < 0.1) {
      best = lag;
      while (d[best + 1] < d[best])
        ++best;
      break;
    }
    if (d[lag] < d[best])
      best = lag;
  }
  const double a = d[best - 1], b = d[best], c = d[best + 1], bend = a - 2 * b + c;
  const double shift = 0.5 * (a - c) / bend;
  Periodicity result;
  result.frequency_hz = rate / (static_cast<double>(best) + shift);
  result.periodicity = 1 - (b - 0.25 * (a - c) * shift);
  return result;
}

Periodicity analyse(const std::vector<double>& x, double rate) {
  PeriodicityAnalysis analysis;
  analysis.prepare(rate, transform());
  for (const double value : x)
    analysis.tick(value);
  return analysis.result();
}

TEST_CASE("the analysis by transforms equals the definition of the normalised difference") {
  std::mt19937 random(4);
  std::normal_distribution<double> noise;
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 4; ++trial) {
    const double frequency = 90 * std::pow(10, uniform(random)), dirt = 0.3 * uniform(random);
    std::vector<double> x(4096);
    double a[5];
    for (double& value : a)
      value = uniform(random);
    for (std::size_t n = 0; n < x.size(); ++n) {
      x[n] = dirt * noise(random);
      for (int k = 0; k < 5; ++k)
        x[n] += a[k] * sine(frequency * (k + 1), static_cast<double>(n) / 48000);
    }
    const Periodicity fast = analyse(x, 48000), plain = by_definition(x, 48000);
    CHECK(std::abs(fast.frequency_hz / plain.frequency_hz - 1) < 1e-8);
    CHECK(std::abs(fast.periodicity - plain.periodicity) < 1e-8);
  }
}

/// A fifth of a second of a signal, analysed.
template <class Signal> Periodicity analysed(double rate, const Signal& signal) {
  std::vector<double> x(static_cast<std::size_t>(rate / 5));
  for (std::size_t n = 0; n < x.size(); ++n)
    x[n] = signal(static_cast<double>(n) / rate);
  return analyse(x, rate);
}

TEST_CASE("a pure tone is wholly periodic at its own frequency") {
  for (const double rate : kRates)
    for (const double frequency : {60.0, 1021.0}) {
      const Periodicity p =
          analysed(rate, [&](double t) { return 0.3 + 0.02 * sine(frequency, t); });
      CHECK(std::abs(p.frequency_hz / frequency - 1) < 1e-3);
      CHECK(p.periodicity > 0.999);
      CHECK(p.harmonicity_db > 30);
      CHECK(std::abs(p.centroid_hz / frequency - 1) < 0.05);
    }
}

TEST_CASE("what has no period has no frequency, and a missing fundamental is the fundamental") {
  for (const double rate : kRates) {
    for (const double time : {0.01, 0.1, 1.0}) { // s, in which a displacement dies away
      INFO(rate, " Hz, ", time, " s");
      const Periodicity p = analysed(rate, [&](double t) { return 1e-6 * std::exp(-t / time); });
      CHECK(p.frequency_hz == 0);
      CHECK(p.periodicity == 0);
    }
    const Periodicity third =
        analysed(rate, [](double t) { return sine(400, t) + sine(600, t) + sine(800, t); });
    CHECK(std::abs(third.frequency_hz - 200) < 0.2);
  }
}

TEST_CASE("harmonicity is the ratio of tone to noise") {
  std::mt19937 random(6);
  std::normal_distribution<double> noise;
  for (const double db : {5.0, 10.0, 20.0}) {
    double mean = 0;
    constexpr int kTrials = 12;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<double> x(4096);
      const double sigma = std::sqrt(0.5 * std::pow(10, -db / 10));
      for (std::size_t n = 0; n < x.size(); ++n)
        x[n] = sine(230, static_cast<double>(n) / 48000) + sigma * noise(random);
      mean += analyse(x, 48000).harmonicity_db / kTrials;
    }
    // The least of many lags is a little below the typical one; a tone's difference averaged over
    // one period and a half, as far as the first minimum lies, is within 1 dB of its power.
    CHECK(std::abs(mean - db) < 1.5);
  }
}

TEST_CASE("the regime tells silence, periodic motion and noise apart, two frames late") {
  Playability estimator;
  estimator.prepare(48000, transform());
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.02);
  const auto run = [&](double seconds, auto signal) {
    for (int n = 0; n < static_cast<int>(seconds * 48000); ++n)
      estimator.tick(signal(n / 48000.0));
    return estimator.regime();
  };
  CHECK(run(0.3, [](double) { return -0.04; }) == Regime::kSilent);
  CHECK(run(0.5, [](double t) { return 0.03 * sine(220, t); }) == Regime::kPeriodic);
  CHECK(run(0.5, [](double t) { return 0.03 * (sine(220, t) + 0.3 * sine(351, t)); }) ==
        Regime::kQuasiPeriodic);
  CHECK(run(0.5, [&](double) { return noise(random); }) == Regime::kChaotic);
  CHECK(run(1, [](double) { return 0.0; }) == Regime::kSilent);
  // A lone frame of another kind changes no label.
  REQUIRE(run(0.5, [](double t) { return 0.03 * sine(220, t); }) == Regime::kPeriodic);
  while (estimator.periodicity().periodicity > 0.9)
    estimator.tick(noise(random));
  CHECK(estimator.regime() == Regime::kPeriodic);
}

static_assert(PlayabilityParameters{}.mode == PlayabilityParameters::Mode::kRobust);
constexpr PlayabilityParameters::Mode kModes[] = {PlayabilityParameters::Mode::kPaper,
                                                  PlayabilityParameters::Mode::kRobust};

/// f_p after a signal, and the largest of its last half.
struct PlayabilityResult {
  double last = 0, largest = 0, envelope = 0;
};

PlayabilityResult playability_of(const std::vector<double>& x, double rate,
                                 PlayabilityParameters::Mode mode, bool analysis = true) {
  Playability estimator;
  PlayabilityParameters p;
  p.mode = mode;
  estimator.set(p);
  estimator.set_analysis(analysis);
  estimator.prepare(rate, transform());
  PlayabilityResult result;
  for (std::size_t n = 0; n < x.size(); ++n) {
    estimator.tick(x[n]);
    if (2 * n >= x.size())
      result.largest = std::max(result.largest, estimator.playability());
  }
  result.last = estimator.playability();
  result.envelope = estimator.follower().envelope();
  return result;
}

/// Noise and a tone of the same rms, rad.
void check_noise(double rate, double level, double seconds) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0, level);
  std::vector<double> noise(static_cast<std::size_t>(seconds * rate)), note(noise.size());
  for (std::size_t n = 0; n < noise.size(); ++n) {
    noise[n] = normal(random);
    note[n] = level * std::sqrt(2) * sine(220, static_cast<double>(n) / rate);
  }
  for (const auto mode : kModes) {
    CHECK(playability_of(noise, rate, mode).largest < 0.1);
    const PlayabilityResult played = playability_of(note, rate, mode);
    CHECK(played.last == doctest::Approx(played.envelope / (played.envelope + 0.03)));
  }
}

TEST_CASE("every mode tells white noise from a tone of the same level, and leaves the tone alone") {
  check_noise(48000, 0.03, 0.5);
}

TEST_CASE("every mode tells white noise from a tone at any level and rate" *
          doctest::test_suite("slow")) {
  for (const double rate : kRates)
    for (const double level : {0.003, 0.03, 0.3})
      check_noise(rate, level, 1);
}

TEST_CASE("the robust mode tells a valve shaken at random from a note, the paper's cannot") {
  // White noise through a resonator, as a valve of 600 Hz and Q = 1 moves under it: it crosses
  // some 600 times a second, which is no very high number and never jumps.
  constexpr double rate = 48000, w = 2 * kPi * 600 / rate, q = 1;
  const double alpha = std::sin(w) / (2 * q), a0 = 1 + alpha;
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0, 1);
  std::vector<double> x(static_cast<std::size_t>(rate));
  for (std::size_t n = 2; n < x.size(); ++n)
    x[n] = (2 * std::cos(w) * x[n - 1] - (1 - alpha) * x[n - 2] + 0.003 * normal(random)) / a0;
  // The robust mode is itself whether or not the analysis' outlets are asked for.
  for (const bool analysis : {true, false})
    CHECK(playability_of(x, rate, PlayabilityParameters::Mode::kRobust, analysis).largest < 0.1);
  CHECK(playability_of(x, rate, PlayabilityParameters::Mode::kPaper, false).last > 0.3);
}

TEST_CASE("the analysis runs when it is asked for or the mode needs it, by a transform") {
  const auto frames = [](PlayabilityParameters::Mode mode, bool analysis, bool transforms = true) {
    Playability estimator;
    estimator.prepare(48000, transforms ? transform() : nullptr);
    PlayabilityParameters p;
    p.mode = mode;
    estimator.set_analysis(analysis);
    estimator.set(p);
    CHECK(estimator.analysis() == analysis);
    for (int n = 0; n < 48000; ++n)
      estimator.tick(0.03 * sine(220, n / 48000.0));
    CHECK(estimator.playability() > 0.3); // envelope and crossings are followed in any case
    return estimator.frames();
  };
  CHECK(frames(PlayabilityParameters::Mode::kPaper, false) == 0);
  CHECK(frames(PlayabilityParameters::Mode::kPaper, true) == 43); // (48000 - 4096)/1024 + 1
  CHECK(frames(PlayabilityParameters::Mode::kRobust, false) == 43);
  CHECK(frames(PlayabilityParameters::Mode::kRobust, true, false) == 0);
}

TEST_CASE("no number on the inlet does no harm") {
  Playability estimator;
  estimator.prepare(48000, transform());
  for (int n = 0; n < 24000; ++n) {
    double x = 0.03 * sine(220, n / 48000.0);
    if (n % 7 == 0)
      x = std::numeric_limits<double>::quiet_NaN();
    if (n % 11 == 0)
      x = std::numeric_limits<double>::infinity();
    if (n % 13 == 0)
      x = -1e300;
    estimator.tick(x);
  }
  CHECK(std::isfinite(estimator.playability()));
  CHECK(std::isfinite(estimator.periodicity().harmonicity_db));
  for (int n = 0; n < 48000; ++n)
    estimator.tick(0.03 * sine(220, n / 48000.0));
  CHECK(estimator.playability() > 0.3);
}

} // namespace
} // namespace tactus::reed

#include "core/particle/cloud.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

// Single grains and bubbles, the noise of a rustle, and the store of energy behind them.

using namespace tactus;
using namespace tactus::particle;

namespace {

constexpr double kRate = 48000;
constexpr double kRates[] = {22050, 48000, 192000};
constexpr double kPi = std::numbers::pi;

/// x with that probability below it, by halving.
double normal_quantile(double probability) {
  double low = -6, high = 6;
  for (int i = 0; i < 60; ++i) {
    const double x = .5 * (low + high);
    (.5 * std::erfc(-x / std::sqrt(2.)) < probability ? low : high) = x;
  }
  return low;
}

/// Kurtosis and variance of a rustle of variance 1.
void check_gaussian(int count, double tolerance) {
  Random random(3);
  Rustle rustle;
  rustle.prepare(kRate);
  rustle.set(1500, 0.8, 1);
  double squares = 0, fourths = 0;
  for (int n = 0; n < count; ++n) {
    const double y = rustle.next(random);
    squares += y * y / count;
    fourths += y * y * y * y / count;
  }
  CHECK(squares == doctest::Approx(1).epsilon(tolerance));
  CHECK(fourths == doctest::Approx(3).epsilon(3 * tolerance));
}

} // namespace

TEST_CASE("shakes arrive within the attack and fall as exp(-t / decay) within 0.1 dB over 60 dB") {
  for (const double rate : kRates)
    for (const double attack : {1e-5, .02, .3}) {
      EnergyStore store;
      store.set(rate, attack, .05);
      CHECK(store.empty());
      store.add_energy(2);
      CHECK(!store.empty());
      double worst_db = 0, sum = 0;
      for (long n = 0; n < static_cast<long>(7 * rate) && !store.empty(); ++n) {
        const double t = static_cast<double>(n + 1) / rate, energy = store.advance(0);
        sum += energy / rate;
        const double expected =
            2 * (std::exp(-t / .05) - std::exp(-t / attack)) * .05 / (.05 - attack);
        // The first milliseconds of a slow attack are stepped.
        if (expected > 2e-6 && t > std::min(.3 * attack, .02))
          worst_db = std::max(worst_db, 10 * std::abs(std::log10(energy / expected)));
      }
      CAPTURE(rate);
      CAPTURE(attack);
      CHECK(worst_db < .1);
      CHECK(sum == doctest::Approx(2 * .05).epsilon(2e-3)); // energy times decay
      CHECK(store.empty());
      for (long n = 0; n < static_cast<long>(rate); ++n)
        store.advance(3);
      CHECK(store.energy() == doctest::Approx(3 * .05).epsilon(1e-6)); // power times decay
      store.reset();
      CHECK(store.empty());
    }
  EnergyStore store; // limits: 1000 a shake, 1e6/s, 1e-5 to 60 s
  store.set(kRate, 1e-9, 1e9);
  CHECK(store.decay_s() == 60);
  store.add_energy(5000);
  store.add_energy(-1);
  CHECK(store.advance(0) == doctest::Approx(1000).epsilon(.15));
  store.set(kRate, 1e-9, 1e-9);
  CHECK(store.decay_s() == 1e-5);
  store.reset();
  CHECK(store.advance(1e9) == doctest::Approx(1e6 * 1e-5).epsilon(.2));
}

TEST_CASE("grains of unit strength hold unit energy, whatever their frequency and quality") {
  Random random(1);
  for (const double rate : {22050.0, 48000.0}) {
    for (const double quality : {0.5, 8.0}) {
      GrainBank bank;
      bank.prepare(rate);
      double sum = 0;
      const int count = 2000;
      for (int i = 0; i < count; ++i) {
        bank.start({300.0 + 4 * i, quality, 0.003, 1}, random);
        while (bank.sounding() > 0) {
          const double y = bank.next();
          sum += y * y;
        }
      }
      // The energy of one grain varies by about its own size; 2000 of them: 2.2 to 4 %.
      CHECK(sum / rate / count == doctest::Approx(1).epsilon(0.1));
    }
  }
}

TEST_CASE("a bubble sounds at 3/r, decays by 0.13/r + 0.0072 r^-3/2 and rises, by its phase") {
  // The rate of the flow exp(-d t) (1 - cos(phase))/phase', by central differences.
  for (const double rate : kRates)
    for (const double rise : {0., .2}) {
      BubbleBank bank;
      bank.prepare(rate);
      bank.start(0.003, 1, rise);
      const double decay = bubble_decay_per_s(0.003);
      CHECK(decay == doctest::Approx(87.15).epsilon(1e-4));
      double worst = 0;
      for (int n = 0; n < 0.02 * rate; ++n) { // f (1 + rise d t)
        const auto flow = [&](double t) {
          const double phase = 2000 * kPi * (t + 0.5 * rise * decay * t * t);
          return std::exp(-decay * t) * (1 - std::cos(phase)) /
                 (2000 * kPi * (1 + rise * decay * t));
        };
        constexpr double kStep = 1e-7; // s; the error is (2000 pi kStep)^2/6
        const double t = n / rate, expected = (flow(t + kStep) - flow(t - kStep)) / (2 * kStep);
        worst = std::max(worst, std::abs(bank.next() - expected));
      }
      CAPTURE(rate);
      CHECK(worst < 1e-6);
    }
}

TEST_CASE("the pressure of a bubble has no mean, as its flow begins and ends at rest") {
  for (const double radius : {1e-3, 3e-3, 8e-3})
    for (const double rise : {0., .1, 1.}) {
      BubbleBank bank;
      bank.prepare(kRate);
      bank.start(radius, 1, rise);
      double sum = 0, squares = 0;
      int samples = 0;
      for (; bank.sounding() > 0; ++samples) {
        const double p = bank.next();
        sum += p;
        squares += p * p;
      }
      CAPTURE(radius);
      CAPTURE(rise);
      // A damped sine alone has sum = rate/w, hundreds of times as much.
      CHECK(std::abs(sum) < 0.02 * kRate * radius / (6 * kPi));
      CHECK(squares / kRate == doctest::Approx(1 / (4 * bubble_decay_per_s(radius))).epsilon(.02));
    }
}

TEST_CASE("the noise of grains and rustles is Marsaglia's xorshift32 through the band-pass") {
  // Each by hand, from the published generator (13, 17, 5) and the bilinear band-pass.
  struct Band {
    std::uint32_t state;
    double gain, a1, a2, x1 = 0, x2 = 0, y1 = 0, y2 = 0;
    Band(std::uint32_t seed, double f, double quality) : state(seed | 1U) {
      const double w = 2 * kPi * f / kRate, a = std::sin(w) / (2 * quality);
      gain = a / (1 + a), a1 = -2 * std::cos(w) / (1 + a), a2 = (1 - a) / (1 + a);
    }
    double next(double deviation) {
      state ^= state << 13;
      state ^= state >> 17;
      state ^= state << 5;
      // A uniform integer of 32 bits has the deviation 2^32 / sqrt(12).
      const double x = deviation * static_cast<std::int32_t>(state) * std::sqrt(12.) / 0x1p32;
      const double y = gain * (x - x2) - a1 * y1 - a2 * y2;
      x2 = std::exchange(x1, x);
      y2 = std::exchange(y1, y);
      return y;
    }
  };
  Random random(7), same(7);
  GrainBank bank;
  bank.prepare(kRate);
  bank.start({2000, 3, .004, .5}, random);
  Band band(static_cast<std::uint32_t>(same.next() >> 32), 2000, 3);
  const double w = 2 * kPi * 2000 / kRate, a = std::sin(w) / 6,
               kept = std::exp(-1 / (.004 * kRate));
  double deviation = .5 * std::sqrt(kRate * (1 - kept * kept) * (1 + a) / a), worst = 0, size = 0;
  for (int n = 0; n < 1000; ++n, deviation *= kept) {
    const double expected = band.next(deviation);
    worst = std::max(worst, std::abs(bank.next() - expected));
    size = std::max(size, std::abs(expected));
  }
  CHECK(worst < 1e-9 * size);

  Rustle rustle;
  rustle.prepare(kRate);
  rustle.set(1500, .8, 2);
  Random first(5), again(5);
  std::vector<Band> bands;
  for (int i = 0; i < 6; ++i)
    bands.emplace_back(static_cast<std::uint32_t>(again.next() >> 32),
                       1500 * std::exp(.8 * normal_quantile((2 * i + 1) / 12.)), 2);
  worst = size = 0;
  for (int n = 0; n < 1000; ++n) {
    double expected = 0;
    for (Band& one : bands)
      expected +=
          one.next(std::sqrt(1 / (one.gain * 6))); // white noise leaves `gain` of its variance
    worst = std::max(worst, std::abs(rustle.next(first) - expected));
    size = std::max(size, std::abs(expected));
  }
  CHECK(worst < 1e-4 * size); // its quantiles have six figures
}

TEST_CASE("a rustle is Gaussian, of variance 1") { check_gaussian(200000, 0.06); }
// A hundred thousand times the length of its correlation: 2 %.
TEST_CASE("a rustle's kurtosis is 3 within 6 %" * doctest::test_suite("slow")) {
  check_gaussian(2000000, 0.02);
}

TEST_CASE("as many grains and bubbles sound as there is room for, as long as they last") {
  Random random(2);
  GrainBank grains;
  grains.prepare(kRate);
  for (int i = 0; i < 400; ++i)
    grains.start({1000, 1, .004, 1}, random);
  CHECK(grains.sounding() == 256);
  // 60 dB of envelope and filter: 6.9 (4 ms + 1/(pi 1000)) = 29.8 ms, and up to 32 samples until it
  // is looked for.
  int samples = 0;
  while (grains.sounding() > 0 && samples < 10000) {
    grains.next();
    ++samples;
  }
  CHECK(samples >= .0298 * kRate);
  CHECK(samples <= .0298 * kRate + 33);
  grains.start({1000, 1, .004, -1}, random);
  grains.start({1000, 1, .004, 0}, random);
  CHECK(grains.sounding() == 0);
  grains.start({1000, 1, .004, 1}, random);
  grains.prepare(kRate); // the same rate: nothing happens
  CHECK(grains.sounding() == 1);
  grains.prepare(44100);
  CHECK(grains.sounding() == 0);

  BubbleBank bubbles;
  bubbles.prepare(kRate);
  for (int i = 0; i < 200; ++i)
    bubbles.start(.003, .5, 0);
  CHECK(bubbles.sounding() == 128);
  for (samples = 0; bubbles.sounding() > 0 && samples < 100000; ++samples)
    bubbles.next();
  CHECK(samples == doctest::Approx(6.9 / bubble_decay_per_s(.003) * kRate).epsilon(1e-3));
  bubbles.start(.0001, 1, 0); // held at 0.15 mm: 20 kHz
  CHECK(bubbles.sounding() == 1);
  bubbles.reset();
  bubbles.start(.003, 0, 0);
  CHECK(bubbles.sounding() == 0);
  // A rising one ends where the band does: f (1 + d t) = 0.48 of the rate.
  bubbles.start(.0003, 1, 1);
  double last = 0;
  for (samples = 0; bubbles.sounding() > 0 && samples < 100000; ++samples)
    last = bubbles.next();
  const double f = bubble_frequency_hz(.0003), d = bubble_decay_per_s(.0003);
  CHECK(samples == doctest::Approx((.48 * kRate / f - 1) / d * kRate).epsilon(.03));
  CHECK(std::isfinite(last));
  BubbleBank slow; // too high for the rate: left out
  slow.prepare(22050);
  slow.start(.00025, 1, 0);
  CHECK(slow.sounding() == 0);
}

TEST_CASE(
    "several grains at once sound as each does alone, also when one ends and another moves up") {
  Random both(21), first(21), second(21);
  second.next(); // the second grain's noise begins with the second number
  GrainBank together, one, two;
  for (GrainBank* bank : {&together, &one, &two})
    bank->prepare(kRate);
  const Grain a{900, 2, .002, 1}, b{2500, 1, .006, .4};
  together.start(a, both);
  together.start(b, both);
  one.start(a, first);
  two.start(b, second);
  double difference = 0, size = 0;
  for (int n = 0; n < 3000; ++n) {
    const double alone = one.next() + two.next();
    difference = std::max(difference, std::abs(together.next() - alone));
    size = std::max(size, std::abs(alone));
  }
  CHECK(one.sounding() == 0);
  CHECK(difference < 1e-12 * size);
}

#include "core/particle/cloud.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

// Spectra, sizes and limits of what aggregates are made of.

using namespace tactus;
using namespace tactus::particle;

namespace {

constexpr double kRate = 48000;
constexpr double kPi = std::numbers::pi;

/// Mean power of a sound at some frequencies, relative to white noise of the same variance:
/// periodograms of Hann windows of 4096 samples.
std::vector<double> spectrum(const std::function<double()>& next, const std::vector<double>& at_hz,
                             int windows) {
  constexpr int kLength = 4096;
  std::vector<double> power(at_hz.size(), 0.0), sound(kLength);
  for (int w = 0; w < windows; ++w) {
    for (double& y : sound)
      y = next();
    for (std::size_t i = 0; i < at_hz.size(); ++i) {
      std::complex<double> sum = 0;
      for (int n = 0; n < kLength; ++n)
        sum += sound[static_cast<std::size_t>(n)] * (1 - std::cos(2 * kPi * n / kLength)) *
               std::polar(1.0, -2 * kPi * at_hz[i] * n / kRate);
      power[i] += std::norm(sum) / (1.5 * kLength * windows);
    }
  }
  return power;
}

/// |H|^2 of the bilinear band-pass with its centre at f0, 1 there.
double band_pass(double f, double f0, double quality) {
  const double w = 2 * kPi * f0 / kRate, a = std::sin(w) / (2 * quality);
  const std::complex<double> z = std::polar(1.0, -2 * kPi * f / kRate);
  return std::norm(a * (1.0 - z * z) / (1 + a - 2 * std::cos(w) * z + (1 - a) * z * z));
}

/// x with that probability below it, by halving.
double normal_quantile(double probability) {
  double low = -6, high = 6;
  for (int i = 0; i < 60; ++i) {
    const double x = .5 * (low + high);
    (.5 * std::erfc(-x / std::sqrt(2.)) < probability ? low : high) = x;
  }
  return low;
}

std::vector<double> sound_of(const CloudSettings& settings, int samples, double energy = 1) {
  Cloud cloud;
  cloud.seed(9);
  cloud.prepare(kRate);
  cloud.set(settings);
  cloud.add_energy(energy);
  std::vector<double> sound;
  for (int n = 0; n < samples; ++n)
    sound.push_back(cloud.next(0));
  return sound;
}

double energy_of(const std::vector<double>& sound) {
  double sum = 0;
  for (const double y : sound)
    sum += y * y;
  return sum / kRate;
}

} // namespace

TEST_CASE("a grain is noise in a band of its frequency and quality") {
  Random random(4);
  for (const double quality : {.7, 4.}) {
    CAPTURE(quality);
    const std::vector<double> at{500, 1400, 2000, 2300, 3000, 6000};
    GrainBank bank;
    bank.prepare(kRate);
    // Many long grains, of which only the beginning is heard: 2 s of decay are a constant level
    // here.
    std::vector<double> power(at.size(), 0.0);
    for (int i = 0; i < 60; ++i) {
      bank.reset();
      bank.start({2000, quality, 2, 1}, random);
      for (int n = 0; n < 2000; ++n)
        bank.next();
      const auto one = spectrum([&] { return bank.next(); }, at, 6);
      for (std::size_t k = 0; k < at.size(); ++k)
        power[k] += one[k] / 60;
    }
    for (std::size_t k = 0; k < at.size(); ++k) { // 360 windows: 5 %
      CAPTURE(at[k]);
      CHECK(power[k] / power[2] ==
            doctest::Approx(band_pass(at[k], 2000, quality) / band_pass(2000, 2000, quality))
                .epsilon(.2));
    }
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

TEST_CASE("a rustle's six bands stand at the middles of six equal parts of its distribution") {
  Random random(12);
  Rustle rustle;
  rustle.prepare(kRate);
  rustle.set(1500, .8, 6);
  std::vector<double> centre, at;
  for (int i = 0; i < 6; ++i)
    centre.push_back(1500 * std::exp(.8 * normal_quantile((2 * i + 1) / 12.)));
  for (const double f : centre)
    for (const double beside : {.9, 1., 1.1})
      at.push_back(beside * f);
  for (int n = 0; n < 4000; ++n) // until it has swung in
    rustle.next(random);
  const auto power = spectrum([&] { return rustle.next(random); }, at, 250);
  for (std::size_t k = 0; k < at.size(); ++k) {
    double expected = 0; // noise of variance 1/6 in each band
    for (const double f : centre) {
      const double a = std::sin(2 * kPi * f / kRate) / 12;
      expected += band_pass(at[k], f, 6) * (1 + a) / a / 6;
    }
    CAPTURE(at[k]);
    CHECK(power[k] == doctest::Approx(expected).epsilon(.25)); // four standard errors
  }
  // Bands at one frequency are six noises, not one.
  rustle.set(1000, 0, 2);
  double square = 0;
  for (int n = 0; n < 400000; ++n) {
    const double y = rustle.next(random);
    square += y * y / 400000;
  }
  CHECK(square == doctest::Approx(1).epsilon(.05));
}

TEST_CASE("what has been reset sounds like new") {
  for (const auto kind : {CloudSettings::Kind::kGrains, CloudSettings::Kind::kBubbles,
                          CloudSettings::Kind::kRustle}) {
    CloudSettings settings;
    settings.kind = kind;
    settings.count = 3000;
    Cloud used, fresh;
    for (Cloud* cloud : {&used, &fresh}) {
      cloud->prepare(kRate);
      cloud->set(settings);
    }
    used.add_energy(1);
    for (int n = 0; n < 3000; ++n)
      used.next(.3);
    used.reset();
    CHECK(used.silent());
    CHECK(used.energy() == 0);
    CHECK(used.next(0) == 0);
    bool same = true, sounds = false;
    for (Cloud* cloud : {&used, &fresh}) {
      cloud->seed(5);
      cloud->add_energy(1);
    }
    for (int n = 0; n < 3000; ++n) {
      const double y = used.next(0);
      same = same && y == fresh.next(0);
      sounds = sounds || y != 0;
    }
    CHECK(same);
    CHECK(sounds);
  }
}

TEST_CASE("shakes arrive within the attack and leave energy times decay, a power holds power times "
          "decay") {
  for (const double attack : {.001, .02, .3}) {
    EnergyStore store;
    store.set(kRate, attack, .05);
    CHECK(store.empty());
    store.add_energy(2);
    CHECK(!store.empty());
    double sum = 0;
    for (int n = 0; n < 48000 * 7; ++n) {
      const double t = (n + 1) / kRate, energy = store.advance(0);
      sum += energy / kRate;
      // 2 (e^(-t/decay) - e^(-t/attack)) decay/(decay - attack)
      if (n % 480 == 0)
        CHECK(energy == doctest::Approx(2 * (std::exp(-t / .05) - std::exp(-t / attack)) * .05 /
                                        (.05 - attack))
                            .epsilon(.02)
                            .scale(1e-3));
    }
    CHECK(sum == doctest::Approx(2 * .05).epsilon(2e-3));
    CHECK(store.empty());
    for (int n = 0; n < 48000; ++n)
      store.advance(3);
    CHECK(store.energy() == doctest::Approx(3 * .05).epsilon(1e-6));
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

TEST_CASE("a power law is held within its ranges, and its mean is the integral") {
  const auto mean_of = [](double exponent, double largest) {
    PowerLaw law;
    law.set(exponent, largest);
    return law.mean();
  };
  const auto integral = [](double exponent, double largest) {
    double above = 0, below = 0; // over the logarithm of the energy, by Simpson's rule
    const int count = 20000;
    for (int i = 0; i <= count; ++i) {
      const double e = std::exp(std::log(largest) * i / count);
      const double weight = (i == 0 || i == count ? 1 : i % 2 ? 4 : 2) * std::pow(e, -exponent);
      above += weight * e;
      below += weight;
    }
    return above / below;
  };
  for (const double exponent : {.3, 1., 1.000000001, 1.7, 4.})
    for (const double largest : {1.5, 100., 1e5})
      CHECK(mean_of(exponent, largest) ==
            doctest::Approx(integral(exponent, largest)).epsilon(1e-5));
  CHECK(mean_of(50, 100) == mean_of(20, 100));
  CHECK(mean_of(19, 100) != mean_of(20, 100));
  CHECK(mean_of(-1, 100) == mean_of(.05, 100));
  CHECK(mean_of(.06, 100) != mean_of(.05, 100));
  CHECK(mean_of(1, 0) == mean_of(1, 1.001));
  CHECK(mean_of(1, 1e12) == mean_of(1, 1e9));
  CHECK(mean_of(1, 9e8) != mean_of(1, 1e9));
}

TEST_CASE("settings are held within their ranges") {
  CloudSettings base;
  base.count = 3000;
  struct Limit {
    double CloudSettings::*setting;
    double beyond, limit, within;
  };
  const auto check = [&](const Limit& l) {
    CloudSettings beyond = base, at = base, inside = base;
    beyond.*l.setting = l.beyond;
    at.*l.setting = l.limit;
    inside.*l.setting = l.within;
    const auto expected = sound_of(at, 4000);
    CHECK(sound_of(beyond, 4000) == expected);
    CHECK(sound_of(inside, 4000) != expected);
  };
  using S = CloudSettings;
  for (const Limit& l : {Limit{&S::decay_s, 1e-9, 1e-4, 2e-4}, Limit{&S::decay_s, 1e9, 60, 40},
                         Limit{&S::frequency_hz, 1, 10, 15},
                         Limit{&S::frequency_hz, 1e9, 20000, 15000}, Limit{&S::spread, -1, 0, .1},
                         Limit{&S::spread, 99, 3, 2.5}, Limit{&S::lower_by_size, -1, 0, .1},
                         Limit{&S::lower_by_size, 9, 2, 1.5}, Limit{&S::quality, 0, .1, .15},
                         Limit{&S::quality, 1e4, 200, 150}, Limit{&S::length_s, 0, 1e-5, 3e-5},
                         Limit{&S::length_s, 99, 2, 1.5}, Limit{&S::level, -1, 0, .1},
                         Limit{&S::level, 1e9, 1e4, 5e3}, Limit{&S::count, -5, 0, 2000}})
    check(l);
  base.kind = CloudSettings::Kind::kBubbles;
  base.count = 300;
  check({&S::rise, -1, 0, .1});
  check({&S::rise, 9, 1, .9});
}

TEST_CASE("variation scales frequency, decay and level, each within its range") {
  CloudSettings settings;
  settings.count = 2000;
  settings.spread = 0;
  const auto varied = [&](double frequency, double decay, double level) {
    Cloud cloud;
    cloud.seed(9);
    cloud.prepare(kRate);
    cloud.set(settings);
    cloud.vary(frequency, decay, level);
    cloud.add_energy(1);
    std::vector<double> sound;
    for (int n = 0; n < 12000; ++n)
      sound.push_back(cloud.next(0));
    return sound;
  };
  const auto plain = varied(1, 1, 1), loud = varied(1, 1, 3);
  CHECK(plain == sound_of(settings, 12000));
  for (std::size_t n = 0; n < plain.size(); n += 97)
    CHECK(loud[n] == doctest::Approx(3 * plain[n]));
  settings.frequency_hz = 3000;
  const auto higher = sound_of(settings, 12000);
  settings.frequency_hz = 1500;
  CHECK(varied(2, 1, 1) == higher);
  settings.decay_s = .1;
  const auto longer = sound_of(settings, 12000);
  settings.decay_s = .05;
  CHECK(varied(1, 2, 1) == longer);
  settings.kind = CloudSettings::Kind::kRustle;
  const auto rustled = sound_of(settings, 12000), lower = varied(.5, 1, 1);
  settings.frequency_hz = 750;
  CHECK(lower == sound_of(settings, 12000));
  CHECK(lower != rustled);
  settings.kind = CloudSettings::Kind::kGrains;
  settings.frequency_hz = 1500;
  CHECK(varied(99, 1, 1) == varied(10, 1, 1));
  CHECK(varied(0, 1, 1) == varied(.1, 1, 1));
  CHECK(varied(1, 99, 1) == varied(1, 10, 1));
  CHECK(varied(1, 0, 1) == varied(1, .1, 1));
  CHECK(varied(1, 1, 1e4) == varied(1, 1, 100));
  CHECK(energy_of(varied(1, 1, -1)) == 0);
}

TEST_CASE("big grains sound lower by their exponent") {
  CloudSettings settings;
  settings.count = 100;
  settings.spread = 0;
  settings.exponent = .05;
  settings.largest = 1.001; // all of size 1
  const auto one = sound_of(settings, 4000);
  settings.lower_by_size = 2;
  const auto same = sound_of(settings, 4000);
  double difference = 0, size = 0;
  for (std::size_t n = 0; n < one.size(); ++n) {
    difference = std::max(difference, std::abs(one[n] - same[n]));
    size = std::max(size, std::abs(one[n]));
  }
  CHECK(difference < .05 * size);
  // Sizes spread evenly over the logarithm from 1 to e^4: by the exponent .5 frequencies fall to
  // e^-2.
  settings = {};
  settings.count = 40000;
  settings.spread = 0;
  settings.quality = 20;
  settings.exponent = .05;
  settings.largest = std::exp(4.);
  settings.lower_by_size = .5;
  settings.frequency_hz = 4000;
  Cloud cloud;
  cloud.prepare(kRate);
  cloud.set(settings);
  const auto power = spectrum([&] { return cloud.next(1); }, {200, 700, 2000, 3600, 8000}, 100);
  CHECK(power[1] > 30 * power[0]); // the lowest frequency is 541 Hz
  CHECK(power[2] > 30 * power[4]);
  // Power ~ size at frequency f0 size^-1/2: low ones are the loud ones.
  CHECK(power[1] > 3 * power[3]);
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

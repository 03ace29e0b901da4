#include "core/particle/cloud.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

using namespace tactus::particle;

namespace {

constexpr double kRates[] = {22050, 44100, 48000, 96000, 192000};

CloudSettings fine_gravel() {
  CloudSettings settings;
  settings.count = 4000;
  settings.exponent = 3;
  settings.largest = 20;
  settings.frequency_hz = 2000;
  settings.spread = 0.5;
  settings.length_s = 0.001;
  settings.decay_s = 0.1;
  return settings;
}

struct Measured {
  double power, events;
};

Measured run(CloudSettings settings, double rate, double seconds) {
  Cloud cloud;
  cloud.seed(4);
  cloud.prepare(rate);
  cloud.set(settings);
  const auto samples = static_cast<long>(seconds * rate);
  double sum = 0;
  for (long n = 0; n < samples; ++n) {
    const double y = cloud.next(1);
    sum += y * y;
  }
  return {sum / static_cast<double>(samples), static_cast<double>(cloud.events())};
}

} // namespace

TEST_CASE("the energy of a store falls as exp(-t / decay) within 0.1 dB over 60 dB at any rate") {
  for (const double rate : kRates) {
    EnergyStore store;
    store.set(rate, 1e-5, 0.1);
    store.add_energy(1);
    double first = 0;
    double worst = 0;
    const auto begin = static_cast<long>(0.001 * rate); // the energy has arrived by then
    for (long n = 0; n < static_cast<long>(0.7 * rate); ++n) {
      const double energy = store.advance(0);
      if (n < begin)
        continue;
      if (n == begin)
        first = energy;
      const double passed = static_cast<double>(n - begin) / rate;
      const double fallen_db = 10 * std::log10(energy / first);
      if (fallen_db > -60)
        worst = std::max(worst, std::abs(fallen_db + 10 * passed / 0.1 / std::numbers::ln10));
    }
    CHECK(worst < 0.1);
  }
}

TEST_CASE("each unit of energy causes its count of events, at any sample rate") {
  CloudSettings settings = fine_gravel();
  for (const double rate : kRates) {
    // 60 units of energy, less what is still in the store at the end; 490 is one standard error.
    const double expected = settings.count * (60 - settings.decay_s);
    settings.level = 0;
    CHECK(run(settings, rate, 60).events == doctest::Approx(expected).epsilon(0.02));
  }
}

TEST_CASE("the level of grains is the same within 2 % at every sample rate" *
          doctest::skip(kSanitized)) {
  const double at_48000 = run(fine_gravel(), 48000, 30).power;
  for (const double rate : kRates)
    CHECK(std::sqrt(run(fine_gravel(), rate, 30).power / at_48000) ==
          doctest::Approx(1).epsilon(0.02));
}

TEST_CASE("grains of unit strength hold unit energy, whatever their frequency and quality") {
  tactus::Random random(1);
  for (const double rate : {22050.0, 192000.0}) {
    for (const double quality : {0.5, 8.0}) {
      GrainBank bank;
      bank.prepare(rate);
      double sum = 0;
      const int count = 4000;
      for (int i = 0; i < count; ++i) {
        bank.start({300.0 + 2 * i, quality, 0.003, 1}, random);
        while (bank.sounding() > 0) {
          const double y = bank.next();
          sum += y * y;
        }
      }
      // The energy of one grain varies by about its own size; 4000 of them: 1.6 to 3 %.
      CHECK(sum / rate / count == doctest::Approx(1).epsilon(0.08));
    }
  }
}

TEST_CASE("a bubble of 3 mm sounds at 1000 Hz and decays at 87.15 1/s at any sample rate") {
  const double decay = 0.13 / 0.003 + 0.0072 / std::pow(0.003, 1.5);
  CHECK(bubble_decay_per_s(0.003) == doctest::Approx(decay));
  CHECK(decay == doctest::Approx(87.15).epsilon(1e-3));
  for (const double rate : kRates) {
    BubbleBank bank;
    bank.prepare(rate);
    bank.start(0.003, 1, 0);
    std::vector<double> sound;
    while (bank.sounding() > 0)
      sound.push_back(bank.next());
    // Complex demodulation at 1 kHz: the slope of the phase is the error of the frequency.
    const auto at = [&](double begin_s) {
      std::complex<double> sum = 0;
      const auto from = static_cast<std::size_t>(begin_s * rate);
      const auto length = static_cast<std::size_t>(0.01 * rate);
      for (std::size_t n = from; n < from + length; ++n)
        sum += sound[n] *
               (1 - std::cos(2 * std::numbers::pi * static_cast<double>(n - from) /
                             static_cast<double>(length))) *
               std::polar(1.0, -2000 * std::numbers::pi * static_cast<double>(n) / rate);
      return sum;
    };
    const double difference = (std::floor(0.02 * rate) - std::floor(0.002 * rate)) / rate;
    const auto ratio = at(0.02) / at(0.002);
    CHECK(1000 + std::arg(ratio) / (2 * std::numbers::pi * difference) ==
          doctest::Approx(1000).epsilon(0.002));
    CHECK(-std::log(std::abs(ratio)) / difference == doctest::Approx(decay).epsilon(0.01));
  }
}

TEST_CASE("a rising bubble passes f (1 + rise d t), by its phase") {
  BubbleBank bank;
  bank.prepare(192000);
  bank.start(0.003, 1, 0.2);
  const double decay = bubble_decay_per_s(0.003);
  double worst = 0;
  for (int n = 0; n < 3000; ++n) {
    const double t = n / 192000.0;
    const double phase = 2000 * std::numbers::pi * (t + 0.1 * decay * t * t);
    worst = std::max(worst, std::abs(bank.next() - std::exp(-decay * t) * std::sin(phase)));
  }
  CHECK(worst < 1e-9);
}

TEST_CASE("a rustle is as loud as the countless grains it stands for, and Gaussian") {
  CloudSettings settings = fine_gravel();
  const double grains = run(settings, 48000, 30).power;
  settings.kind = CloudSettings::Kind::kRustle;
  for (const double rate : kRates)
    CHECK(std::sqrt(run(settings, rate, 30).power / grains) == doctest::Approx(1).epsilon(0.02));
  tactus::Random random(3);
  Rustle rustle;
  rustle.prepare(48000);
  rustle.set(1500, 0.8, 1);
  double squares = 0, fourths = 0;
  const int count = 2000000; // a hundred thousand times the correlation's length: 2 %
  for (int n = 0; n < count; ++n) {
    const double y = rustle.next(random);
    squares += y * y / count;
    fourths += y * y * y * y / count;
  }
  CHECK(squares == doctest::Approx(1).epsilon(0.02));
  CHECK(fourths == doctest::Approx(3).epsilon(0.06));
}

TEST_CASE("the same seed gives the same bits and another seed another sound") {
  Cloud a, b, c;
  a.seed(1);
  b.seed(1);
  c.seed(2);
  for (Cloud* cloud : {&a, &b, &c}) {
    cloud->prepare(48000);
    cloud->set(fine_gravel());
  }
  bool same = true, other = false;
  for (int n = 0; n < 48000; ++n) {
    const double x = a.next(0.5);
    same = same && x == b.next(0.5);
    other = other || x != c.next(0.5);
  }
  CHECK(same);
  CHECK(other);
}

TEST_CASE("absurd settings and powers stay finite and end in silence") {
  const double odd[] = {0, -1, 1e300, 1e-300, std::numeric_limits<double>::infinity(), 3};
  for (const auto kind :
       {CloudSettings::Kind::kGrains, CloudSettings::Kind::kBubbles, CloudSettings::Kind::kRustle})
    for (const double value : odd) {
      CloudSettings settings{kind,  value, value, value, value, value, value,
                             value, value, value, value, value, 1};
      Cloud cloud;
      cloud.prepare(44100);
      cloud.set(settings);
      cloud.add_energy(value);
      bool finite = true;
      for (int n = 0; n < 2000; ++n)
        finite = finite && std::isfinite(cloud.next(n % 3 ? value : std::nan("")));
      CHECK(finite);
      settings.decay_s = settings.attack_s = 0.001;
      settings.length_s = 0.001;
      cloud.set(settings);
      for (int n = 0; n < 44100 * 5; ++n)
        finite = finite && std::isfinite(cloud.next(0));
      CHECK(finite);
    }
}

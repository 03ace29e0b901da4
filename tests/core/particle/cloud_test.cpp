#include "core/dsp/complex.hpp"
#include "core/particle/cloud_rows.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <vector>

// Clouds of grains, bubbles and rustles: levels, counts, and what their settings do.

using namespace tactus;
using namespace tactus::particle;
using Kind = CloudSettings::Kind;

namespace {

constexpr double kRate = 48000;

CloudSettings fine_gravel() {
  return {.count = 4000,
          .decay_s = 0.1,
          .exponent = 3,
          .largest = 20,
          .frequency_hz = 2000,
          .spread = 0.5,
          .length_s = 0.001};
}

std::vector<double> sound_of(const CloudSettings& settings, int samples, std::uint64_t seed = 9) {
  Cloud cloud;
  cloud.seed(seed);
  cloud.prepare(kRate);
  cloud.set(settings);
  cloud.add_energy(1);
  std::vector<double> sound;
  for (int n = 0; n < samples; ++n)
    sound.push_back(cloud.next(0));
  return sound;
}

/// Under a power of one unit a second E tends to the decay time: rms level sqrt(decay), and count
/// events a second.
void check_level_and_count(std::initializer_list<double> rates, double seconds, double tolerance) {
  for (const Kind kind : {Kind::kGrains, Kind::kRustle})
    for (const double rate : rates) {
      CAPTURE(rate);
      CloudSettings settings = fine_gravel();
      settings.kind = kind;
      Cloud cloud;
      cloud.seed(4);
      cloud.prepare(rate);
      cloud.set(settings);
      const auto begin = static_cast<long>(rate), end = begin + static_cast<long>(seconds * rate);
      double sum = 0;
      std::uint64_t before = 0;
      for (long n = 0; n < end; ++n) {
        const double y = cloud.next(1);
        sum += n < begin ? 0 : y * y;
        before = n < begin ? cloud.events() : before;
      }
      CHECK(std::sqrt(sum / static_cast<double>(end - begin) / settings.decay_s) ==
            doctest::Approx(1).epsilon(tolerance));
      if (kind == Kind::kGrains)
        CHECK(static_cast<double>(cloud.events() - before) / (settings.count * seconds) ==
              doctest::Approx(1).epsilon(tolerance));
    }
}

} // namespace

// Of n grains, whose energies differ by about as much as themselves, the rms is known to
// 0.8/sqrt(n).
TEST_CASE("grains and rustles have the level and the count of their settings at any rate") {
  check_level_and_count({22050, 96000}, 3, 0.03);
}
TEST_CASE("the level and count of grains and rustles hold within 2 % at every rate" *
          doctest::test_suite("slow")) {
  check_level_and_count({22050, 44100, 48000, 96000, 192000}, 30, 0.02);
}

TEST_CASE("a seed repeats its bits, another does not, and what has been reset sounds like new") {
  for (const Kind kind : {Kind::kGrains, Kind::kBubbles, Kind::kRustle}) {
    CloudSettings settings;
    settings.kind = kind;
    settings.count = 3000;
    const auto first = sound_of(settings, 3000, 5);
    CHECK(first != sound_of(settings, 3000, 6));
    Cloud used;
    used.prepare(kRate);
    used.set(settings);
    used.add_energy(1);
    for (int n = 0; n < 3000; ++n)
      used.next(.3);
    used.reset();
    CHECK(used.silent());
    CHECK(used.energy() == 0);
    CHECK(used.next(0) == 0);
    used.seed(5);
    used.add_energy(1);
    for (const double y : first)
      REQUIRE(used.next(0) == y);
  }
}

TEST_CASE("absurd settings and powers stay finite and end in silence") {
  const double odd[] = {0, -1, 1e300, 1e-300, std::numeric_limits<double>::infinity(), 3};
  for (const Kind kind : {Kind::kGrains, Kind::kBubbles, Kind::kRustle})
    for (const double value : odd) {
      CloudSettings settings{kind,  value, value, value, value, value, value,
                             value, value, value, value, value, 1};
      Cloud cloud;
      cloud.prepare(8000);
      cloud.set(settings);
      cloud.add_energy(value);
      bool finite = true;
      for (int n = 0; n < 2000; ++n)
        finite = finite && std::isfinite(cloud.next(n % 3 ? value : std::nan("")));
      settings.decay_s = settings.attack_s = settings.length_s = 0.001;
      cloud.set(settings);
      for (int n = 0; n < 8000 * 8 && !cloud.silent(); ++n) // the largest bubble: 7 s
        finite = finite && std::isfinite(cloud.next(0));
      CHECK(finite);
      CHECK(cloud.silent());
    }
}

TEST_CASE("settings are clamped to the ranges of their rows, and matter up to there") {
  for (const Parameter& row : kCloudRows) {
    if (!row.choices.empty())
      continue;
    CloudSettings base;
    const bool bubbles = row.name == "rise";
    base.kind = bubbles ? CloudSettings::Kind::kBubbles : CloudSettings::Kind::kGrains;
    base.count = bubbles ? 300 : 1500;
    const auto sound_at = [&](double value) {
      CloudSettings settings = base;
      row.set(&settings, value);
      return sound_of(settings, 2000);
    };
    INFO(std::string(row.name));
    const double span = row.highest - row.lowest;
    for (const auto& [limit, beyond, within] :
         {std::array{row.lowest, row.lowest - 1, row.lowest + 0.01 * span},
          std::array{row.highest, 2 * row.highest + 1, row.highest - 0.2 * span}}) {
      const auto expected = sound_at(limit);
      CHECK(sound_at(beyond) == expected);
      CHECK(sound_at(within) != expected);
    }
  }
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
  for (const double y : varied(1, 1, -1))
    REQUIRE(y == 0);
}

TEST_CASE("big grains sound lower by their exponent") {
  // Sizes spread evenly over the logarithm from 1 to e^4: by the exponent 0.5 frequencies fall from
  // 4 kHz to 541 Hz, with power ~ size: low ones are the loud ones.
  const CloudSettings settings{.count = 40000,
                               .exponent = .05,
                               .largest = std::exp(4.),
                               .frequency_hz = 4000,
                               .spread = 0,
                               .lower_by_size = .5,
                               .quality = 20};
  Cloud cloud;
  cloud.prepare(kRate);
  cloud.set(settings);
  // Periodograms of Hann windows.
  constexpr int kLength = 4096;
  const double at_hz[] = {200, 700, 2000, 3600, 8000};
  std::vector<double> power(5, 0.0), sound(kLength);
  for (int window = 0; window < 20; ++window) {
    for (double& y : sound)
      y = cloud.next(1);
    for (std::size_t i = 0; i < power.size(); ++i) {
      Complex sum = 0;
      const auto turn = tactus::math::polar(1.0, -2 * std::numbers::pi * at_hz[i] / kRate);
      for (std::size_t n = kLength; n-- > 0;)
        sum = sum * turn +
              sound[n] * (1 - std::cos(2 * std::numbers::pi * static_cast<double>(n) / kLength));
      power[i] += norm(sum);
    }
  }
  CHECK(power[1] > 30 * power[0]);
  CHECK(power[2] > 30 * power[4]);
  CHECK(power[1] > 3 * power[3]);
}

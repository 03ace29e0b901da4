#include "core/dsp/complex.hpp"
#include "core/particle/particle_system.hpp"
#include "core/particle/presets.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <vector>

using namespace tactus::particle;

namespace {

constexpr double kRates[] = {22050, 44100, 48000, 96000, 192000};

/// Steady tones: bubbles of one size that overlap.
CloudSettings tones() {
  return {.kind = CloudSettings::Kind::kBubbles,
          .count = 30,
          .attack_s = 1e-3,
          .decay_s = 0.05,
          .largest = 1.001,
          .frequency_hz = 400,
          .spread = 0,
          .rise = 0,
          .level = 0.1};
}

/// The lowest bending modes of a free disk (Leissa 1969, NASA SP-160, for Poisson's ratio
/// 0.33): lambda^2 / (2 pi a^2) h sqrt(E / (12 rho (1 - nu^2))).
double disk_hz(double lambda_squared, double diameter, double thickness, double young,
               double density, double poisson) {
  const double a = diameter / 2;
  return lambda_squared / (2 * std::numbers::pi * a * a) * thickness *
         std::sqrt(young / (12 * density * (1 - poisson * poisson)));
}

} // namespace

TEST_CASE(
    "a mode struck by a unit impulse holds the square of its gain, rings at its frequency and "
    "loses 60 dB in its time, at any sample rate") {
  for (const double rate : kRates)
    for (const double frequency : {300.0, 2500.0, 7000.0})
      for (const double t60 : {0.02, 0.4}) {
        const RingingMode mode{frequency, t60, 0.7};
        RingingBody body;
        body.prepare(rate);
        body.set({&mode, 1});
        double sum = 0;
        tactus::Complex first = 0, last = 0;
        const auto window = static_cast<long>(t60 / 3 * rate);
        const auto turn = [&](long n) {
          return tactus::math::polar(1.0, -2 * std::numbers::pi * frequency *
                                              static_cast<double>(n) / rate);
        };
        for (long n = 0; n < static_cast<long>(2 * t60 * rate); ++n) {
          const double y = body.next(n == 0 ? 2 : 0);
          sum += y * y / rate;
          const double hann = 1 - std::cos(2 * std::numbers::pi * static_cast<double>(n % window) /
                                           static_cast<double>(window));
          if (n < window)
            first += hann * y * turn(n);
          else if (n < 2 * window)
            last += hann * y * turn(n);
        }
        CAPTURE(rate);
        CAPTURE(frequency);
        // The sum of a sampled square differs from its integral by less than 1 % while a period has
        // three samples and the decay a few periods.
        CHECK(sum == doctest::Approx(4 * 0.49).epsilon(0.01));
        CHECK(20 * std::log10(abs(first / last)) == doctest::Approx(20).epsilon(0.02));
        CHECK(std::abs(arg(last / first)) < 0.03);
      }
}

TEST_CASE("a body comes to rest in silence, and modes that are no longer listed ring out") {
  const RingingMode modes[] = {{500, 0.1, 1}, {1200, 0.1, 1}};
  RingingBody whole, changed;
  for (RingingBody* body : {&whole, &changed}) {
    body->prepare(48000);
    body->set(modes);
    CHECK(body->at_rest());
    static_cast<void>(body->next(1));
    CHECK_FALSE(body->at_rest());
  }
  changed.set({});
  for (int n = 0; n < 48000 && !whole.at_rest(); ++n)
    CHECK(whole.next(0) == changed.next(0));
  CHECK(whole.at_rest());
  CHECK(changed.next(1) == 0);
  CHECK(changed.at_rest());
  const RingingMode beyond{12000, 0.1, 1}; // of the band
  changed.prepare(22050);
  changed.set({&beyond, 1});
  for (int n = 0; n < 100; ++n)
    CHECK(changed.next(n == 0) == 0);
}

namespace {

/// Level^2 E^2 (direct^2 + sum g^2) / decay.
void check_mean_power(std::initializer_list<double> rates, std::initializer_list<double> counts,
                      int seconds, double tolerance) {
  const RingingMode modes[] = {{400, 0.05, 0.5}, {1300, 0.05, 1}};
  for (const auto kind : {CloudSettings::Kind::kGrains, CloudSettings::Kind::kRustle})
    for (const double rate : rates)
      for (const double count : counts) {
        const CloudSettings settings{.kind = kind,
                                     .count = count,
                                     .decay_s = 0.05,
                                     .exponent = 2,
                                     .largest = 2,
                                     .frequency_hz = 5000,
                                     .spread = 0,
                                     .quality = 3,
                                     .length_s = 0.0005,
                                     .level = 0.002};
        ParticleSystem system;
        system.prepare(rate);
        system.set(settings);
        system.set_body(modes, 0.5);
        double sum = 0;
        const auto begin = static_cast<long>(rate), end = static_cast<long>((1 + seconds) * rate);
        for (long n = 0; n < end; ++n) {
          const double y = system.next(20).sound;
          sum += n < begin ? 0 : y * y;
        }
        CAPTURE(rate);
        CAPTURE(count);
        const double expected = 0.002 * std::sqrt((0.25 + 0.25 + 1) / 0.05);
        CHECK(std::sqrt(sum / static_cast<double>(end - begin)) ==
              doctest::Approx(expected).epsilon(tolerance));
      }
}

} // namespace

// Narrow noises: 69 Hz and 30 s leave 2 % of the power of each mode to chance, rms 1 %.
TEST_CASE("the mean power is level^2 E^2 (direct^2 + sum g^2) / decay") {
  check_mean_power({22050}, {2000}, 3, 0.12);
}
TEST_CASE("the mean power is that of theory at any density" * doctest::test_suite("slow")) {
  check_mean_power({22050, 96000}, {50, 2000}, 30, 0.04);
}

TEST_CASE("a body that many collisions strike is not deflected on average") {
  const RingingMode mode{100, 0.2, 1};
  ParticleSystem system;
  system.prepare(48000);
  CloudSettings settings;
  settings.count = 1000;
  settings.level = 1;
  system.set(settings);
  system.set_body({&mode, 1}, 0);
  double sum = 0, squares = 0;
  for (int n = 0; n < 96000; ++n) {
    const double y = system.next(10).sound;
    sum += y;
    squares += y * y;
  }
  CHECK(std::abs(sum / 96000) < 0.05 * std::sqrt(squares / 96000));
}

namespace {

void check_impulses(int seconds, double tolerance) {
  ParticleSystem system;
  system.prepare(48000);
  CloudSettings settings = tones();
  settings.count = 20;
  settings.exponent = 2;
  settings.largest = 5;
  settings.level = 0; // the outlet does not depend on it
  system.set(settings);
  double squares = 0, count = 0;
  for (int n = 0; n < 48000 * seconds; ++n) {
    const auto sample = system.next(40); // E tends to 2
    squares += sample.collisions * sample.collisions;
    count += sample.collisions > 0;
  }
  CHECK(count == doctest::Approx(20 * 40 * seconds).epsilon(tolerance / 2));
  CHECK(squares / count == doctest::Approx(2).epsilon(tolerance)); // 1.7 % share a sample
}

} // namespace

// Of n collisions the mean of energies is known to 0.5/sqrt(n), their number to 1/sqrt(n).
TEST_CASE("the impulses' squares have the mean of their collisions' energies") {
  check_impulses(10, 0.08);
}
TEST_CASE("the impulses' squares have that mean within 4 %" * doctest::test_suite("slow")) {
  check_impulses(100, 0.04);
}

TEST_CASE("reset fades within 5 ms and keeps the shakes that come meanwhile") {
  for (const bool shaken : {false, true}) {
    ParticleSystem system;
    system.prepare(48000);
    system.set(tones());
    system.shake(50);
    double size = 0, step = 0, previous = 0, later = 0;
    for (int n = 0; n < 9600; ++n) {
      if (n == 4800)
        system.reset();
      if (n == 4850)
        system.shake(shaken ? 50 : 0);
      const double y = system.next(0).sound;
      if (n < 4800)
        size = std::max(size, std::abs(y));
      else if (n < 5040)
        step = std::max(step, std::abs(y - previous));
      else
        later = std::max(later, std::abs(y));
      previous = y;
    }
    // Sines of 400 Hz turn by 0.052 a sample, and the fade takes 1/240 of the size.
    CHECK(step < 0.08 * size);
    CHECK((later > 0) == shaken);
    CHECK(system.at_rest() == !shaken);
  }
}

TEST_CASE("a reset at rest takes no time, and one in a fade does not begin it again") {
  ParticleSystem system;
  system.prepare(48000);
  system.set(tones());
  system.reset();
  system.shake(1);
  CHECK(system.next(0).energy > 0);
  for (int n = 0; n < 2400; ++n)
    static_cast<void>(system.next(0));
  system.reset();
  for (int n = 0; n < 239; ++n) {
    if (n == 100)
      system.reset();
    CHECK(system.next(0).energy > 0);
  }
  static_cast<void>(system.next(0));
  CHECK(system.next(0).energy == 0);
}

TEST_CASE("no power and no number leave what is at rest at rest") {
  ParticleSystem system;
  system.prepare(48000);
  system.set(tones());
  for (const double power : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                             -std::numeric_limits<double>::infinity()})
    for (int n = 0; n < 100; ++n) {
      const auto sample = system.next(power);
      CHECK((sample.sound == 0 && sample.collisions == 0 && sample.energy == 0));
      CHECK(system.at_rest());
    }
}

TEST_CASE("presets have names of their own and numbers within the object's ranges") {
  for (const Preset& preset : presets()) {
    CAPTURE(preset.name);
    CHECK(find_preset(preset.name) == &preset);
    CHECK(preset.cloud.count >= 1);
    CHECK(preset.cloud.decay_s >= 0.01);
    CHECK(preset.mode_count <= RingingBody::kMaxModes);
    for (const RingingMode& mode : preset.body()) {
      CHECK((mode.frequency_hz >= 20 && mode.frequency_hz < 0.45 * 44100));
      CHECK((mode.t60_s >= 0.001 && mode.gain > 0));
    }
  }
  CHECK(find_preset("moon") == nullptr);
}

TEST_CASE("a preset's numbers follow from what it names") {
  // Cook's maraca and tambourine, per sample at 22.05 kHz.
  const double rate = 22050;
  const auto decay = [rate](double kept) { return -1 / (rate * std::log(kept)); };
  const CloudSettings& maraca = find_preset("maraca")->cloud;
  CHECK(maraca.decay_s == doctest::Approx(decay(0.999)).epsilon(0.01));
  CHECK(maraca.length_s == doctest::Approx(decay(0.95)).epsilon(0.01));
  CHECK(maraca.count == doctest::Approx(25.0 / 1024 * rate * decay(0.999)).epsilon(0.01));
  CHECK(maraca.quality == doctest::Approx(std::numbers::pi * 3200 * decay(0.96)).epsilon(0.01));
  const Preset& tambourine = *find_preset("tambourine");
  CHECK(tambourine.modes[1].t60_s == doctest::Approx(std::log(1000.0) * decay(0.99)).epsilon(0.01));
  // Coins of 90 % silver: E = 82 GPa, 10300 kg/m^3, Poisson's ratio 0.37.
  const Preset& coins = *find_preset("coins");
  const double shapes[] = {5.253, 9.084, 12.23};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(coins.modes[i].frequency_hz ==
          doctest::Approx(disk_hz(shapes[i], 0.0381, 0.0024, 82e9, 10300, 0.37)).epsilon(0.01));
    CHECK(coins.modes[i + 3].frequency_hz ==
          doctest::Approx(disk_hz(shapes[i], 0.0306, 0.00215, 82e9, 10300, 0.37)).epsilon(0.01));
  }
  // A tumbler (French 1983): h / (2 pi R^2) sqrt(3 E / (5 rho)) sqrt(1 + 4/3 (R / H)^4); rings'
  // modes n (n^2 - 1) / sqrt(n^2 + 1) above it.
  const Preset& ice = *find_preset("ice");
  const double radius = 0.035, wall = 0.0025, height = 0.1;
  const double lowest = wall / (2 * std::numbers::pi * radius * radius) *
                        std::sqrt(3 * 70e9 / (5 * 2500)) *
                        std::sqrt(1 + 4.0 / 3 * std::pow(radius / height, 4));
  for (std::size_t i = 0; i < 3; ++i) {
    const double n = static_cast<double>(i) + 2;
    const double ratio = n * (n * n - 1) / std::sqrt(n * n + 1) / (6 / std::sqrt(5.0));
    CHECK(ice.modes[i].frequency_hz == doctest::Approx(lowest * ratio).epsilon(0.01));
  }
  // Bubbles of 1 to 8 mm: 3 kHz to 375 Hz, density ~ r^(-10/3), energy ~ r^3.
  const CloudSettings& bubbles = find_preset("bubbles")->cloud;
  CHECK(bubbles.frequency_hz * std::pow(bubbles.largest, -bubbles.lower_by_size) ==
        doctest::Approx(bubble_frequency_hz(0.008)).epsilon(0.01));
  CHECK(bubbles.exponent == doctest::Approx((10.0 / 3 - 1) / 3).epsilon(0.01));
}

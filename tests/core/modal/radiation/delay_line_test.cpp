// The delay from a body to a listener: exact at rest, smooth in a glide.
#include "core/modal/radiation/delay_line.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;

TEST_CASE("a delay line gives the same bits sample by sample and in blocks of any size") {
  for (const double delay : {0.0, 0.3, 1.0, 1.7, 2.0, 63.2, 64.9, 500.25, 4799.0})
    for (const std::size_t block : {1UL, 5UL, 64UL, 100UL, 4096UL}) {
      CAPTURE(delay);
      CAPTURE(block);
      const bool bends = block % 2 == 1;
      DelayLine one, other;
      for (DelayLine* line : {&one, &other}) {
        line->prepare(4801);
        line->set(1.5 * delay, false, true);
        line->set(delay, bends, false); // a glide first
      }
      std::vector<float> in(12000);
      for (std::size_t n = 0; n < in.size(); ++n)
        in[n] = static_cast<float>(std::sin(0.3 * static_cast<double>(n)) +
                                   std::sin(1e-4 * static_cast<double>(n * n)));
      std::vector<float> single = in, cut = in;
      for (float& x : single)
        x = one.step(x);
      for (std::size_t n = 0; n < cut.size(); n += block)
        other.run(cut.data() + n, std::min(block, cut.size() - n));
      CHECK(single == cut);
    }
}

namespace {

/// What a resting line does to a tone: its gain, and the phase against the exact delay.
Complex response(double delay, double radians_per_sample) {
  DelayLine line;
  line.prepare(2000);
  line.set(delay, false, true);
  constexpr std::size_t kSettled = 1100, kCount = 6000;
  std::vector<float> sound(kCount);
  for (std::size_t n = 0; n < kCount; ++n)
    sound[n] = static_cast<float>(std::sin(radians_per_sample * static_cast<double>(n)));
  line.run(sound.data(), kCount);
  Complex sum = 0;
  double weight = 0;
  for (std::size_t n = kSettled; n < kCount; ++n) {
    const double u = static_cast<double>(n - kSettled) / (kCount - kSettled);
    const double window = 1 - std::cos(2 * kPi * u);
    sum += window * static_cast<double>(sound[n]) *
           tactus::math::polar(1.0, -radians_per_sample * (static_cast<double>(n) - delay));
    weight += window;
  }
  return 2.0 * Complex(0, 1) * sum / weight;
}

} // namespace

TEST_CASE(
    "a delayed tone is flat within 0.1 dB to 20 kHz at 44.1 kHz and arrives within 0.01 samples") {
  for (const double delay : {20.5, 33.25, 57.5, 100.75, 1000.1})
    for (const double frequency : {100.0, 1000.0, 8000.0, 12000.0, 16000.0, 18000.0, 20000.0}) {
      CAPTURE(delay);
      CAPTURE(frequency);
      const double omega = 2 * kPi * frequency / 44100;
      const auto gain = response(delay, omega);
      CHECK(std::abs(20 * std::log10(abs(gain))) < 0.1);
      CHECK(std::abs(arg(gain)) / omega < 0.01);
    }
}

TEST_CASE(
    "a delay shorter than the kernel's half is exact when whole and good at low frequencies") {
  for (const double delay : {0.0, 1.0, 2.0, 7.0, 19.0})
    CHECK(abs(response(delay, 2.8) - 1.0) < 1e-4);
  for (const double delay : {2.5, 5.25, 13.75})
    CHECK(std::abs(20 * std::log10(abs(response(delay, kPi / 2)))) < 0.25);
}

TEST_CASE("a delay that is moved in steps at 1 kHz glides as one that moves smoothly") {
  // A listener that goes away at 1 m/s: 1/346.1 samples a sample.
  constexpr double kSpeed = 1 / 346.1, kTone = 2 * kPi * 3000 / kRate;
  constexpr std::size_t kUpdate = 48, kSettled = 8192;
  for (const bool bends : {true, false}) {
    CAPTURE(bends);
    DelayLine line;
    line.prepare(4800);
    line.set(100, bends, true);
    std::vector<float> sound(2 * kSettled);
    for (std::size_t n = 0; n < sound.size(); ++n) {
      if (n % kUpdate == 0)
        line.set(100 + kSpeed * static_cast<double>(n), bends, false);
      sound[n] = line.step(static_cast<float>(std::sin(kTone * static_cast<double>(n))));
    }
    // Beyond the cross-fade's or the window's own width.
    CHECK(off_tone_level_db(std::span(sound).subspan(kSettled), 3000, bends ? 28 : 300) < -60);
  }
}

TEST_CASE("a gliding delay is the exact one at every sample, and no jump makes it too fast") {
  constexpr double kTone = 0.4;
  DelayLine line;
  line.prepare(4800);
  line.set(50, true, true);
  line.set(3000, true, false); // 20 m
  std::vector<float> sound(40000);
  double last = 0, fastest = 0;
  for (std::size_t n = 0; n < sound.size(); ++n)
    sound[n] = line.step(static_cast<float>(std::sin(kTone * static_cast<double>(n))));
  // The phase by the tone's quarter-turned twin: instantaneous frequency from three samples.
  for (std::size_t n = 200; n < sound.size(); ++n) { // the onset rings
    const double middle = static_cast<double>(sound[n - 1]);
    if (std::abs(middle) < 0.5)
      continue;
    const double turn = std::acos(std::clamp(
        0.5 * (static_cast<double>(sound[n]) + static_cast<double>(sound[n - 2])) / middle, -1.0,
        1.0));
    fastest = std::max(fastest, std::abs(turn / kTone - 1));
    last = turn;
  }
  CHECK(fastest < DelayLine::kMaxSlope + 0.01);
  CHECK(last == approx(kTone).epsilon(1e-4));
  CHECK(std::abs(static_cast<double>(sound.back()) - std::sin(kTone * (39999.0 - 3000))) < 1e-4);
}

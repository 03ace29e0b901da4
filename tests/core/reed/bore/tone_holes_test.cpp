#include "core/reed/bore/tone_hole_end.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/instrument/tuning.hpp"
#include "core/reed/playability/linear_stability.hpp"
#include "core/reed/player/player.hpp"
#include "tests/core/reed/bore/bore_echo.hpp"
#include "tests/core/reed/bore/bore_reference.hpp"
#include "tests/core/reed/render.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

// Tone holes: the filters against their own rational functions, these against energy, and the bore
// that they end against finite elements (bench/reed_bores/reference.py).

namespace tactus::reed {
namespace {

using namespace test;
using Complex = std::complex<double>;
constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr BoreEnd kEnds[] = {BoreEnd::kClarinet, BoreEnd::kSaxophone, BoreEnd::kOboe};

Parameters bore_of(BoreEnd end) {
  const char* names[] = {"", "clarinet", "sax", "oboe"};
  Parameters p = find_preset(names[static_cast<int>(end)]).value();
  p.cup_volume = 0; // the reference has none
  return p;
}

const Termination& row(BoreEnd end, int key) {
  for (const Termination& one : terminations(end))
    if (one.key == key)
      return one;
  FAIL("no such fingering");
  return terminations(end).front();
}

} // namespace

TEST_CASE("bores with tone holes resonate where finite elements say, and as high" *
          doctest::skip(kSanitized)) {
  double worst_cents = 0, worst_db = 0;
  for (const BoreReference& reference : kBoreReference)
    for (const double rate : {44100.0, 48000.0, 96000.0}) {
      const Parameters p = bore_of(reference.end);
      const auto echo = echo_of(p, row(reference.end, reference.key), reference.length, rate,
                                static_cast<std::size_t>(0.5 * rate));
      for (const auto& peak : reference.peaks) {
        if (!(peak.hz > 0))
          continue;
        const auto [at, high_db] = peak_near(p, echo, rate, peak.hz);
        CAPTURE(static_cast<int>(reference.end));
        CAPTURE(reference.key);
        CAPTURE(rate);
        CAPTURE(peak.hz);
        worst_cents = std::max(worst_cents, std::abs(cents(at, peak.hz)));
        CHECK(std::abs(cents(at, peak.hz)) < 5);
        // Close to a cone's apex air flows to and fro without travelling, and its friction is not
        // in the line's G: what peaks of long waves (k r_0 < 0.55) are too high by.
        const double near_apex = kTwoPi * peak.hz / air_at(20).sound_speed * p.apex_distance;
        const bool lacks_friction = p.shape == BoreShape::kCone && near_apex < 0.55;
        if (!lacks_friction)
          worst_db = std::max(worst_db, std::abs(high_db - peak.level));
        CHECK(std::abs(high_db - peak.level) < (lacks_friction ? 2.5 : 1));
      }
    }
  MESSAGE("worst: " << worst_cents << " cents, " << worst_db << " dB");
}

TEST_CASE("no fingering reflects more than arrives, at any frequency and rate") {
  for (const BoreEnd end : kEnds)
    for (const Termination& one : terminations(end)) {
      CAPTURE(one.key);
      CHECK(std::abs(one.reflectance(0.0).value) <= 1);
      CHECK(one.reflectance(0.0).value.real() < -0.9);
      for (double hz = 0.01; hz < 1e6; hz *= 1.003)
        REQUIRE(std::abs(one.reflectance({0, kTwoPi * hz}).value) <= 1 + 1e-9);
      const auto left = [](const auto& blocks) {
        for (const Termination::Block& block : blocks)
          CHECK((block.a < 0 && (block.oscillates || block.b < 0)));
      };
      left(one.reflection);
      left(one.radiation);
      for (const double rate : {8000.0, 48000.0, 192000.0}) {
        DigitalReflection digital;
        digital.set(one.reflection, one.dc_value, rate, 1.03, 1);
        for (int i = 0; i <= 2048; ++i)
          REQUIRE(std::abs(digital.at(std::polar(1.0, std::numbers::pi * i / 2048))) <= 1 + 1e-9);
      }
    }
}

TEST_CASE("the sections compute the response that the design says") {
  const Termination& one = row(BoreEnd::kClarinet, 55); // has real and complex poles
  CHECK(std::any_of(one.reflection.begin(), one.reflection.end(),
                    [](const auto& block) { return !block.oscillates; }));
  const double rate = 48000;
  DigitalReflection digital;
  digital.set(one.reflection, one.dc_value, rate, 1.02, 1);
  TerminationFilter<double, Termination::kReflectionBlocks> filter;
  std::vector<double> response(48000);
  {
    decltype(filter)::BlockFilter stretch(filter, digital);
    for (std::size_t n = 0; n < response.size(); ++n)
      response[n] = stretch(n == 0 ? 1.0 : 0.0);
  }
  for (const double hz : {20.0, 300.0, 1700.0, 9000.0}) {
    const Complex back = std::polar(1.0, -kTwoPi * hz / rate);
    Complex sum = 0, turn = 1;
    for (const double x : response) {
      sum += x * turn;
      turn *= back;
    }
    CHECK(std::abs(sum - digital.at(back)) < 1e-6);
    CHECK(std::abs(sum - one.reflectance({0, kTwoPi * hz / 1.02}).value) < 0.04);
  }
  CHECK(std::abs(digital.at(1.0) - one.dc_value) < 1e-9);
  // The derivative, by differences.
  const Complex s(-20, 5000), small(1e-3, 0);
  const Complex slope =
      (one.reflectance(s + small).value - one.reflectance(s - small).value) / 2e-3;
  CHECK(std::abs(one.reflectance(s).derivative - slope) < 1e-6 * std::abs(slope));
}

TEST_CASE("holes are heard as a point source below the cut-off, and let all power out above") {
  for (const int key : {51, 57, 63, 69}) {
    DigitalRadiation radiation;
    radiation.set(row(BoreEnd::kClarinet, key).radiation, 0, 192000, 1, 7.5e-3);
    const double speed = air_at(20).sound_speed;
    // The doubled flow 2 a S/(rho c) as a point source at 1 m: a r/2 k r.
    const double hz = 150, low = 7.5e-3 / 2 * kTwoPi * hz / speed * 7.5e-3;
    const double output = std::abs(radiation.at(std::polar(1.0, -kTwoPi * hz / 192000)));
    CHECK(std::abs(20 * std::log10(output / low)) < 0.5);
    // All of a^2 S/(2 rho c) over 4 pi m^2: a r/2.
    const double high = std::abs(radiation.at(std::polar(1.0, -kTwoPi * 5000 / 192000)));
    CHECK(std::abs(20 * std::log10(high / (7.5e-3 / 2))) < 2);
    CHECK(std::abs(radiation.at(1.0)) < 1e-9);
  }
}

TEST_CASE("a new fingering is there after 5 ms, and nothing grows on the way") {
  const double rate = 48000;
  ToneHoleEnd<double> holes, fresh;
  for (auto* one : {&holes, &fresh})
    one->set(rate, 1, 7.5e-3);
  holes.finger(&row(BoreEnd::kClarinet, 51));
  holes.finger(&row(BoreEnd::kClarinet, 67));
  holes.start_pending_fade();
  fresh.finger(&row(BoreEnd::kClarinet, 67));
  double largest = 0;
  const auto wave = [&](int n) { return std::sin(0.02 * n) + 0.3 * std::sin(0.21 * n); };
  for (int n = 0; n < 4800; ++n) {
    double one = wave(n), other = one;
    holes.reflect(&one, 1);
    fresh.reflect(&other, 1);
    largest = std::max(largest, std::abs(one));
    if (n == 20)
      CHECK(std::abs(one - other) > 1e-3);
    if (n >= 240)
      CHECK(one == doctest::Approx(other).epsilon(1e-12).scale(1));
  }
  CHECK(largest < 1.4); // the input's 1.3, and the filters' own beginning
}

TEST_CASE("with tune 0 the holes change no bit, and with tune they do") {
  for (const char* name : {"clarinet", "sax", "oboe"})
    for (const bool tune : {false, true}) {
      Parameters p = find_preset(name).value();
      p.tune = tune;
      std::vector<double> sounds[2];
      for (const bool holes : {false, true}) {
        p.end = holes ? BoreEnd::kClarinet : BoreEnd::kOpen;
        Instrument instrument;
        instrument.set(p);
        instrument.prepare(48000, 64);
        sounds[holes] = play(instrument, ramp(2000, 0.2, 48000), 48000, 0, 233).sound;
      }
      CHECK((sounds[0] == sounds[1]) == !tune);
    }
}

TEST_CASE("linear theory and tune know the holes") {
  for (const BoreEnd end : kEnds)
    for (const double f : {180.0, 260.0, 350.0}) {
      Parameters p = bore_of(end);
      p.end = end;
      const Termination* fingering = fingering_for(end, f);
      REQUIRE(fingering != nullptr);
      const double length = tuned_length(p, f, p.reed_frequency, 1, {fingering, false});
      const LinearStability theory(p, length, fingering);
      CAPTURE(static_cast<int>(end));
      CAPTURE(f);
      // The threshold of the mode that tune meant, found by another road.
      const Threshold found = theory.threshold(p.reed_frequency, f);
      if (found.found)
        CHECK(std::abs(cents(found.frequency_hz, f)) < 1);
    }
  Parameters player = find_preset("clarinet").value();
  player.tune = true;
  player.lip_channel = 2.5;
  CHECK(tuned(player, 200, 2500).valve.channel_length ==
        doctest::Approx(2.5 * player.channel_length));
  CHECK(tuned(player, 200, 2500).fingering.end == fingering_for(BoreEnd::kClarinet, 200));
  CHECK(embouchure_for(player, 200, 0.4).fingering.end == fingering_for(BoreEnd::kClarinet, 200));
  CHECK(fingering_for(BoreEnd::kOpen, 200) == nullptr);
  CHECK(fingering_for(BoreEnd::kClarinet, 10)->key == 50);
  CHECK(fingering_for(BoreEnd::kClarinet, 1e5)->key == 70);
  for (const double semitones : {-0.45, 0.0, 0.45})
    CHECK(fingering_for(BoreEnd::kClarinet, 261.63 * std::exp2(semitones / 12))->key == 60);
  // The end's own length is what the bore's ideal frequency leaves out.
  for (const BoreEnd end : kEnds) {
    const Parameters p = bore_of(end);
    BoreDesign bore;
    bore.set(p, 48000);
    const Termination* fingering = fingering_for(end, 262);
    bore.set_end(fingering);
    CHECK(bore.ideal_frequency(bore.length_for(262)) == doctest::Approx(262));
    if (end != BoreEnd::kClarinet) // a shut cone without its tip's volume resonates elsewhere
      continue;
    const double length = bore.length_for(262);
    // Wall friction alone is between it and the resonance of theory.
    const Mode mode = LinearStability(p, length, fingering).bore_resonance_near(262);
    CHECK(mode.found);
    CHECK(std::abs(cents(mode.frequency_hz, 262)) < 35);
  }
}

TEST_CASE("fingering plays the note without a bore frequency, and stands above one") {
  for (const double key : {53.0, 60.0, 66.5}) {
    Parameters p = find_preset("clarinet").value();
    p.tune = true;
    p.fingering = key;
    const double note = 440 * std::exp2((key - 69) / 12);
    for (const double given : {0.0, 440.0}) {
      Instrument instrument;
      instrument.set(p);
      instrument.prepare(48000, 64);
      const Recording r = play(instrument, ramp(2200, 1, 48000), 48000, 0, given);
      const auto output = part(r, r.bore_pressure, 0.5, 1);
      CHECK(rms(output) > 100);
      CHECK(std::abs(cents(pitch(output, 48000, 0.95 * note, 1.05 * note), note)) < 10);
    }
  }
}

TEST_CASE("a bend of 70 cents keeps its fingering, and a semitone takes the next") {
  Parameters p = find_preset("clarinet").value();
  p.tune = true;
  BoreDesign bore;
  bore.set(p, 48000);
  Player player;
  player.prepare(48000);
  player.set(p, bore);
  const auto end_at = [&](double cents) {
    return player.control(220 * std::exp2(cents / 1200), p.reed_frequency, 2000).end;
  };
  const Termination* const end = end_at(0);
  REQUIRE(end != nullptr);
  for (int cents = 10; cents <= 70; cents += 10)
    CHECK(end_at(cents) == end);
  const Termination* const next = end_at(100);
  REQUIRE(next != nullptr);
  CHECK(next->key == end->key + 1);
}

TEST_CASE(
    "what comes back from the holes is their reflectance at any rate, and never more than all") {
  for (const BoreEnd end : {BoreEnd::kClarinet, BoreEnd::kSaxophone, BoreEnd::kOboe})
    for (const double rate : {22050.0, 32000.0, 44100.0, 48000.0, 96000.0, 192000.0})
      for (const Termination& fingering : terminations(end)) {
        DigitalReflection digital;
        digital.set(fingering.reflection, fingering.dc_value, rate, 1, 1);
        double largest = 0, apart = 0;
        for (int i = 1; i <= 1000; ++i)
          largest = std::max(largest,
                             std::abs(digital.at(std::polar(1.0, -std::numbers::pi * i / 1000))));
        CHECK(largest <= 1);
        for (double f = 60; f < 4000; f *= 1.05)
          apart = std::max(apart, std::abs(digital.at(std::polar(1.0, -kTwoPi * f / rate)) -
                                           fingering.reflectance({0, kTwoPi * f}).value));
        if (rate > 40e3)
          CHECK(apart < 0.031);
      }
}

} // namespace tactus::reed

#include "core/reed/bore/brass.hpp"

#include "core/reed/instrument/instrument.hpp"
#include "core/reed/instrument/presets.hpp"
#include "tests/core/reed/bore/bell_reference.hpp"
#include "tests/core/reed/bore/bore_echo.hpp"
#include "tests/core/reed/note_measure.hpp"
#include "tests/core/reed/render.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

// Trumpet and trombone: the bell's filters against the horn equation
// (bench/reed_bores/bell_reference.py), and what valves and slide make of the tube.

namespace tactus::reed {
namespace {

using namespace test;
constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr BoreEnd kBells[] = {BoreEnd::kTrumpet, BoreEnd::kTrombone};

Parameters brass(BoreEnd end) {
  Parameters p = find_preset(end == BoreEnd::kTrumpet ? "trumpet" : "trombone").value();
  p.tune = p.tube = true;
  p.end = end;
  return p;
}

const Termination& bell_of(BoreEnd end) { return bells(end).front(); }

} // namespace

TEST_CASE("tubes with a bell resonate where the horn equation says, and as high" *
          doctest::skip(kSanitized)) {
  double worst_cents = 0, worst_db = 0;
  for (const BellReference& reference : kBellReference)
    for (const double rate : {44100.0, 48000.0, 96000.0}) {
      Parameters p = with_brass_tube(brass(reference.end));
      p.cup_volume = 0; // the reference has none
      const auto echo = echo_of(p, bell_of(reference.end), reference.length, rate,
                                static_cast<std::size_t>(0.5 * rate));
      for (const auto& peak : reference.peaks) {
        if (!(peak.hz > 0))
          continue;
        const auto [at, high_db] = peak_near(p, echo, rate, peak.hz);
        CAPTURE(static_cast<int>(reference.end));
        CAPTURE(reference.length);
        CAPTURE(rate);
        CAPTURE(peak.hz);
        worst_cents = std::max(worst_cents, std::abs(cents(at, peak.hz)));
        worst_db = std::max(worst_db, std::abs(high_db - peak.level));
        CHECK(std::abs(cents(at, peak.hz)) < 5);
        CHECK(std::abs(high_db - peak.level) < 1);
      }
    }
  MESSAGE("worst: " << worst_cents << " cents, " << worst_db << " dB");
}

TEST_CASE("no bell reflects more than arrives, at any frequency and rate") {
  for (const BoreEnd end : kBells) {
    const Termination& one = bell_of(end);
    CHECK(bells(end).size() == 1);
    CHECK(std::abs(one.reflectance(0.0).value + 1.0) < 0.01);
    for (double hz = 0.01; hz < 1e6; hz *= 1.001)
      REQUIRE(std::abs(one.reflectance({0, kTwoPi * hz}).value) <= 1 + 1e-9);
    for (const double rate : {8000.0, 48000.0, 192000.0}) {
      DigitalReflection digital;
      digital.set(one.reflection, one.dc_value, rate, 1.03, 1);
      for (int i = 0; i <= 2048; ++i)
        REQUIRE(std::abs(digital.at(std::polar(1.0, std::numbers::pi * i / 2048))) <= 1 + 1e-9);
    }
  }
}

TEST_CASE(
    "slide positions are semitones, and valves together lower by a little less than their sum") {
  for (const BoreEnd end : kBells) {
    const BrassTube& tube = *brass_tube(end);
    const Termination& bell = bell_of(end);
    const double beyond = bell.length_correction(), open = tube.open_length + beyond;
    const auto lowered = [&](double length) { return cents(length + beyond, open) / 100; };
    CHECK(slide_length(tube, bell, 1) == tube.open_length);
    for (const double position : {2.0, 3.5, 7.0})
      CHECK(lowered(slide_length(tube, bell, position)) == doctest::Approx(position - 1));
    CHECK(valve_length(tube, bell, 0) == tube.open_length);
    CHECK(lowered(valve_length(tube, bell, 1)) == doctest::Approx(2));
    CHECK(lowered(valve_length(tube, bell, 2)) == doctest::Approx(1));
    CHECK(lowered(valve_length(tube, bell, 4)) == doctest::Approx(3));
    // Three tubes cut for 2, 1 and 3 semitones of the open one.
    const double all =
        12 * std::log2(std::exp2(2 / 12.0) + std::exp2(1 / 12.0) + std::exp2(3 / 12.0) - 2);
    CHECK(lowered(valve_length(tube, bell, 7)) == doctest::Approx(all));
    CHECK(all < 6);
    CHECK(all > 5.4);
  }
}

TEST_CASE("players take the usual valves and positions") {
  const BrassTube& trumpet = *brass_tube(BoreEnd::kTrumpet);
  const auto valves = [&](int key) {
    return standard_valves(static_cast<int>(
        standard_positions(trumpet, 440 * std::exp2((key - 69) / 12.0)).semitones));
  };
  // Sounding pitch; every beginner's table: low F sharp 123, C 0, D 13, E 12, F 1, F sharp 2, G 0.
  CHECK(valves(52) == 7);
  CHECK(valves(58) == 0);
  CHECK(valves(60) == 5);
  CHECK(valves(62) == 3);
  CHECK(valves(63) == 1);
  CHECK(valves(64) == 2);
  CHECK(valves(65) == 0);
  CHECK(valves(70) == 0);
  const BrassTube& trombone = *brass_tube(BoreEnd::kTrombone);
  const auto slide = [&](int key) {
    return 1 + standard_positions(trombone, 440 * std::exp2((key - 69) / 12.0)).semitones;
  };
  CHECK(slide(40) == doctest::Approx(7).epsilon(0.01)); // E2
  CHECK(slide(46) == doctest::Approx(1).epsilon(0.01));
  CHECK(slide(48) == doctest::Approx(6).epsilon(0.01)); // C3
  CHECK(slide(53) == doctest::Approx(1).epsilon(0.02)); // F3
}

TEST_CASE(
    "the tube's naturals are its modes, nearest to the target, and longer tubes have lower ones") {
  for (const BoreEnd end : kBells) {
    Parameters p = brass(end);
    const BrassTube& tube = *brass_tube(end);
    const Termination& bell = bell_of(end);
    const Parameters played = with_brass_tube(p);
    for (int natural = 2; natural <= 8; ++natural) {
      const double target = natural * tube.fundamental;
      const double open = nearest_natural(played, bell, tube.open_length, target);
      const double longer =
          nearest_natural(played, bell, slide_length(tube, bell, 2), target / 1.0595);
      CAPTURE(natural);
      CAPTURE(static_cast<int>(end));
      // A cylinder of three quarters of the length: the lowest modes lie flat, as measured ones do.
      CHECK(std::abs(cents(open, target)) < (natural == 2 ? 95 : 60));
      CHECK(std::abs(cents(longer, open) + 100) < 35);
    }
  }
}

TEST_CASE(
    "valves that are held choose the tube, whatever the note, and release those of the player") {
  const auto length = [](int valves, double target) {
    Parameters p = brass(BoreEnd::kTrumpet);
    p.tube = false;
    p.valves = valves;
    Instrument instrument;
    instrument.set(p);
    instrument.prepare(48000, 64);
    play(instrument, ramp(1000, 0.05, 48000), 48000, 0, target);
    return instrument.length();
  };
  const BrassTube& tube = *brass_tube(BoreEnd::kTrumpet);
  const Termination& bell = bell_of(BoreEnd::kTrumpet);
  for (const int valves : {0, 2, 5, 7})
    for (const double target : {233.0, 466.0})
      CHECK(length(valves, target) ==
            doctest::Approx(valve_length(tube, bell, static_cast<unsigned>(valves))));
  CHECK(length(-1, 233) != doctest::Approx(length(-1, 466)));
}

TEST_CASE("a trumpet with valves plays its compass in the right register" *
          doctest::skip(kSanitized)) {
  for (const int key : {52, 59, 64, 70, 78})
    for (const double pressure : {700.0, 3000.0, 7000.0}) {
      Instrument instrument;
      instrument.set(brass(BoreEnd::kTrumpet));
      instrument.prepare(48000, 64);
      const double note = 440 * std::exp2((key - 69) / 12.0);
      const Recording r = play(instrument, ramp(pressure, 1.2, 48000), 48000, 0, note);
      const NoteMeasure measured = measure_note(r, note, 0.6, 1.2);
      CAPTURE(key);
      CAPTURE(pressure);
      CHECK(measured.in_register());
      CHECK(std::abs(measured.cents) < 5);
      CHECK(measured.inharmonic_db < -20); // two of its modes sound at some loud keys
    }
}

TEST_CASE("trumpet and trombone swell in one register, without a foreign tone" *
          doctest::skip(kSanitized)) {
  struct Swell {
    const char* preset;
    int key;
    double soft, loud;
  };
  constexpr double kSampleRate = 48000;
  for (const Swell& one : {Swell{"trumpet", 52, 700, 7000}, Swell{"trumpet", 69, 700, 7000},
                           Swell{"trombone", 40, 400, 4500}, Swell{"trombone", 62, 400, 4500}}) {
    Parameters p = find_preset(one.preset).value();
    p.tune = true;
    Instrument instrument;
    instrument.set(p);
    instrument.prepare(kSampleRate, 64);
    std::vector<double> mouth;
    for (int n = 0; n < static_cast<int>(4.3 * kSampleRate); ++n) {
      const double t = n / kSampleRate;
      const double share = std::clamp(t < 2.3 ? (t - 0.3) / 2 : (4.3 - t) / 2, 0.0, 1.0);
      mouth.push_back((one.soft + share * (one.loud - one.soft)) * std::min(1.0, t / 0.02));
    }
    const double note = 440 * std::exp2((one.key - 69) / 12.0);
    const SwellMeasure swell = measure_swell(play(instrument, mouth, kSampleRate, 0, note), note);
    CAPTURE(one.preset);
    CAPTURE(one.key);
    CHECK(swell.wrong_register == 0);
    CHECK(swell.inharmonic_db < -30);
    CHECK(swell.cents < 5);
  }
}

} // namespace tactus::reed

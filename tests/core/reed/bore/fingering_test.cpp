#include "core/reed/bore/hole_fingering.hpp"
#include "core/reed/bore/hole_lattice.hpp"
#include "core/reed/bore/register_vent.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/instrument/tuning.hpp"
#include "tests/core/reed/bore/bore_echo.hpp"
#include "tests/core/reed/bore/bore_reference.hpp"
#include "tests/core/reed/note_measure.hpp"
#include "tests/core/reed/render.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

// Holes fingered one by one, and the register vent: bores against finite elements
// (bench/reed_bores/reference.py), filters against energy, notes against their bores.

namespace tactus::reed {
namespace {

using namespace test;
using Complex = std::complex<double>;
constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr BoreEnd kEnds[] = {BoreEnd::kClarinet, BoreEnd::kSaxophone, BoreEnd::kOboe};

std::vector<double> state_of(std::string_view letters) {
  std::vector<double> closed;
  for (const char letter : letters)
    closed.push_back(letter == 'c' ? 1 : letter == 'h' ? 0.5 : letter == 'q' ? 0.75 : 0);
  return closed;
}

/// The standard fingering: what is above the note's first open hole is closed.
std::vector<double> standard(const Woodwind& wind, int key) {
  std::vector<double> closed(wind.tone_holes(), 0);
  for (std::size_t i = 0; i < closed.size(); ++i)
    closed[i] = wind.key_of(i) > key ? 1 : 0;
  return closed;
}

Parameters clarinet() {
  Parameters p = find_preset("clarinet").value();
  p.tune = true;
  p.register_note = 440;
  return p;
}

double frequency_of(double key) { return 440 * std::exp2((key - 69) / 12); }

/// With the register vent in front.
std::vector<double> prepend_vent(double vent, std::vector<double> holes) {
  holes.insert(holes.begin(), vent);
  return holes;
}

Instrument make_instrument(const Parameters& p) {
  Instrument instrument;
  instrument.set(p);
  instrument.prepare(48000, 64);
  return instrument;
}

/// Hz that the fingering sounds; 0: nothing within 12 % of near.
double sounding_pitch(std::string_view holes, double near_hz) {
  Instrument instrument = make_instrument(clarinet());
  REQUIRE(instrument.finger_holes(prepend_vent(1, state_of(holes))));
  const Recording r = play(instrument, ramp(2000, 0.8, 48000), 48000, 0, 0);
  const auto output = part(r, r.bore_pressure, 0.4, 0.8);
  return rms(output) > 100 ? pitch(output, 48000, 0.89 * near_hz, 1.12 * near_hz) : 0;
}

double largest_step(std::span<const double> x) {
  double step = 0;
  for (std::size_t i = 1; i < x.size(); ++i)
    step = std::max(step, std::abs(x[i] - x[i - 1]));
  return step;
}

} // namespace

TEST_CASE("any state of the holes resonates where finite elements say, and as high" *
          doctest::skip(kSanitized)) {
  double worst_cents = 0, worst_db = 0;
  for (const FingeredReference& reference : kFingeredReference) {
    Parameters p = find_preset("clarinet").value();
    p.cup_volume = 0;
    p.wall_loss = 1;
    Termination end;
    REQUIRE(finger_holes(*woodwind(reference.end), state_of(reference.holes), end));
    for (const double rate : {44100.0, 96000.0}) {
      const auto echo =
          echo_of(p, end, reference.length, rate, static_cast<std::size_t>(0.5 * rate));
      for (const auto& peak : reference.peaks) {
        if (!(peak.hz > 0) || peak.level < 4) // a shoulder is no resonance
          continue;
        const ImpedancePeak found = peak_near(p, echo, rate, peak.hz);
        CAPTURE(reference.holes);
        CAPTURE(rate);
        CAPTURE(peak.hz);
        CHECK(std::abs(cents(found.hz, peak.hz)) < 5);
        CHECK(std::abs(found.level - peak.level) < 1);
        worst_cents = std::max(worst_cents, std::abs(cents(found.hz, peak.hz)));
        worst_db = std::max(worst_db, std::abs(found.level - peak.level));
      }
    }
  }
  MESSAGE("worst: " << worst_cents << " cents, " << worst_db << " dB");
}

TEST_CASE("a bore with its register vent open resonates where finite elements say" *
          doctest::skip(kSanitized)) {
  double worst_cents = 0, worst_db = 0;
  for (const BoreReference& reference : kVentedReference) {
    Parameters p = find_preset("clarinet").value();
    p.cup_volume = 0;
    p.wall_loss = 1;
    const Termination* const end = fingering_for(reference.end, frequency_of(reference.key));
    for (const double rate : {44100.0, 96000.0}) {
      const auto echo =
          echo_of(p, *end, reference.length, rate, static_cast<std::size_t>(0.5 * rate), true);
      for (const auto& peak : reference.peaks) {
        if (!(peak.hz > 0) || peak.level < 4)
          continue;
        const ImpedancePeak found = peak_near(p, echo, rate, peak.hz);
        CAPTURE(reference.key);
        CAPTURE(rate);
        CAPTURE(peak.hz);
        // The vent's friction is one number; the mode that it stops is far from its frequency.
        const bool stopped = &peak == &reference.peaks[0];
        CHECK(std::abs(cents(found.hz, peak.hz)) < (stopped ? 12 : 5));
        CHECK(std::abs(found.level - peak.level) < (stopped ? 5 : 1.5));
        worst_cents = std::max(worst_cents, std::abs(cents(found.hz, peak.hz)));
        worst_db = std::max(worst_db, std::abs(found.level - peak.level));
      }
    }
  }
  MESSAGE("worst: " << worst_cents << " cents, " << worst_db << " dB");
}

TEST_CASE("no state of the holes reflects more than arrives, at any frequency and rate") {
  std::mt19937 random(7);
  const auto between_0_and_1 = [&] { return static_cast<double>(random() % 1000) / 999; };
  for (const BoreEnd end : kEnds)
    for (int i = 0; i < (kSanitized ? 3 : 20); ++i) {
      std::vector<double> closed(woodwind(end)->tone_holes());
      for (double& hole : closed) {
        const double x = between_0_and_1();
        hole = x < 0.4 ? 1 : x < 0.7 ? 0 : between_0_and_1();
      }
      Termination found;
      REQUIRE(finger_holes(*woodwind(end), closed, found));
      for (double hz = 0.01; hz < 1e6; hz *= 1.003)
        REQUIRE(std::abs(found.reflectance({0, kTwoPi * hz}).value) <= 1 + 1e-9);
      DigitalReflection digital;
      digital.set(found.reflection, found.dc_value, 48000, 1.03, 1);
      for (int k = 0; k <= 2048; ++k)
        REQUIRE(std::abs(digital.at(std::polar(1.0, std::numbers::pi * k / 2048))) <= 1 + 1e-9);
      for (const auto& blocks : {std::span<const Termination::Block>(found.reflection),
                                 std::span<const Termination::Block>(found.radiation)})
        for (const Termination::Block& block : blocks)
          CHECK((block.a < 0 && (block.oscillates || block.b < 0)));
    }
}

TEST_CASE("standard fingerings come out as the tables have them") {
  for (const BoreEnd end : kEnds)
    for (const Termination& row : terminations(end)) {
      if (row.key % 4 != 0)
        continue;
      const Woodwind& wind = *woodwind(end);
      Termination found;
      REQUIRE(finger_holes(wind, standard(wind, row.key), found));
      CAPTURE(static_cast<int>(end));
      CAPTURE(row.key);
      CHECK(found.key == row.key);
      DigitalRadiation one, other;
      one.set(found.radiation, 0, 192000, 1, 1);
      other.set(row.radiation, 0, 192000, 1, 1);
      for (double hz = 60; hz < 0.8 * wind.cutoff; hz *= 1.02) {
        const Complex s(0, kTwoPi * hz);
        CHECK(std::abs(found.reflectance(s).value - row.reflectance(s).value) < 0.02);
        const Complex back = std::polar(1.0, -kTwoPi * hz / 192000);
        CHECK(std::abs(20 * std::log10(std::abs(one.at(back) / other.at(back)))) < 2.5);
      }
    }
}

TEST_CASE("fingerings are kept, and refused where they are none") {
  HoleFingerings cache;
  const auto states = {standard(*woodwind(BoreEnd::kClarinet), 60),
                       standard(*woodwind(BoreEnd::kClarinet), 62)};
  const Termination* const first = cache.find(BoreEnd::kClarinet, *states.begin());
  REQUIRE(first != nullptr);
  const Termination* const second = cache.find(BoreEnd::kClarinet, *(states.begin() + 1));
  CHECK(second != first);
  CHECK(second->key == 62);
  CHECK(cache.find(BoreEnd::kClarinet, *states.begin()) == first);
  CHECK(cache.find(BoreEnd::kOboe, *states.begin()) == nullptr);
  CHECK(cache.find(BoreEnd::kOpen, {}) == nullptr);
  Instrument instrument = make_instrument(clarinet());
  std::vector<double> holes(21, 1);
  CHECK(instrument.finger_holes(holes));
  holes[3] = std::nan("");
  CHECK_FALSE(instrument.finger_holes(holes));
  holes[3] = 1.5;
  CHECK_FALSE(instrument.finger_holes(holes));
  CHECK_FALSE(instrument.finger_holes(std::span(holes).first(5)));
  CHECK_FALSE(instrument.finger_holes({}));
}

TEST_CASE("the vent gains no power, however far it is open") {
  Parameters p = clarinet();
  struct NoLosses {
    double incident(double x) const { return x; }
  } losses;
  for (const double open : {0.0, 0.3, 1.0}) {
    VentFilter<double> vent;
    vent.set(RegisterVent::of(p), 48000);
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 800);
    double in = 0, out = 0;
    for (int n = 0; n < 20000; ++n) {
      double above = n < 15000 ? noise(random) : 0, below = n < 15000 ? noise(random) : 0;
      in += above * above + below * below;
      vent.pass(losses, &above, &below, {open, 0}, 1);
      out += above * above + below * below;
      REQUIRE(out <= in * (1 + 1e-12));
    }
    CHECK((out < 0.999 * in) == (open > 0));
  }
  // Small waves: H. Large ones meet the jet's loss, and less goes through.
  const RegisterVent design = RegisterVent::of(p);
  for (const double hz : {150.0, 600.0, 2000.0}) {
    double through[2];
    for (const double size : {1e-3, 3e3}) {
      VentFilter<double> vent;
      vent.set(design, 192000);
      Complex sum = 0;
      for (int n = 0; n < 192000; ++n) {
        double above = size * std::cos(kTwoPi * hz * n / 192000), below = 0;
        const double a = above;
        vent.pass(losses, &above, &below, {1, 0}, 1);
        if (n >= 96000)
          sum += (a - below) * std::polar(2.0 / 96000 / size, -kTwoPi * hz * n / 192000);
      }
      through[size > 1] = std::abs(sum);
    }
    CHECK(through[0] == doctest::Approx(std::abs(design.at({0, kTwoPi * hz}))).epsilon(0.02));
    CHECK(through[1] < (hz < 1000 ? 0.95 : 1) * through[0]); // above, mass alone counts
  }
}

TEST_CASE("theory undoes what the vent does") {
  const RegisterVent vent = RegisterVent::of(clarinet());
  const Complex s(0, kTwoPi * 500), vent_path = std::polar(0.97, -1.3),
                                    below = std::polar(0.9, 2.1);
  // What comes back above a vent from what comes back below it.
  const Complex h = vent.at(s), b = below * (1.0 - h) / (1.0 + h * below);
  const Complex up = b - h * (1.0 + b);
  CHECK(std::abs(vent.without_vent(s, vent_path * up, vent_path) - vent_path * below) < 1e-12);
}

TEST_CASE("standard fingerings given as lists are in tune by the places of the holes" *
          doctest::skip(kSanitized)) {
  const Woodwind& wind = *woodwind(BoreEnd::kClarinet);
  for (const int key : {50, 53, 58, 63, 68}) {
    Instrument instrument = make_instrument(clarinet());
    REQUIRE(instrument.finger_holes(prepend_vent(1, standard(wind, key))));
    const Recording r = play(instrument, ramp(2000, 0.8, 48000), 48000, 0, 300);
    const auto output = part(r, r.bore_pressure, 0.4, 0.8);
    const double note = frequency_of(key);
    CAPTURE(key);
    CHECK(rms(output) > 100);
    CHECK(std::abs(cents(pitch(output, 48000, 0.9 * note, 1.1 * note), note)) < 35);
  }
}

TEST_CASE("cross fingerings and half holes sound as their bores say" * doctest::skip(kSanitized)) {
  // First resonances of both states, by finite elements, and what is heard.
  const auto first_peak = [](std::string_view holes) {
    for (const FingeredReference& one : kFingeredReference)
      if (one.holes == holes)
        return one.peaks[0].hz;
    FAIL("no such state");
    return 0.0;
  };
  // The second has the same first open hole with all open beyond it.
  const double open_8 = 281.7; // Hz, of the standard fingering of key 62: place() and its end
  Termination end;
  const Woodwind& wind = *woodwind(BoreEnd::kClarinet);
  REQUIRE(finger_holes(wind, standard(wind, 62), end));
  Parameters p = find_preset("clarinet").value();
  p.wall_loss = 1;
  const auto echo = echo_of(p, end, wind.position(62), 48000, 24000);
  const double plain_peak = peak_near(p, echo, 48000, open_8).hz;
  const double plain = sounding_pitch("ccccccccoooooooooooo", frequency_of(62));
  REQUIRE(plain > 0);
  for (const std::string_view fork : {"ccccccccoccooooooooo", "ccccccccoccccooooooo"}) {
    const double output = sounding_pitch(fork, frequency_of(62));
    CAPTURE(fork);
    REQUIRE(output > 0);
    const double lower = cents(first_peak(fork), plain_peak);
    CHECK(lower < -20);
    CHECK(std::abs(cents(output, plain) - lower) < 25);
  }
  // Covering a hole step by step lowers the note step by step.
  double before = 1e9;
  for (const std::string_view holes : {"ccccccccccoooooooooo", "cccccccccchooooooooo",
                                       "ccccccccccqooooooooo", "cccccccccccooooooooo"}) {
    const double output = sounding_pitch(holes, frequency_of(59.5));
    CHECK(output > 0);
    CHECK(output < before);
    before = output;
  }
}

TEST_CASE("a trill between two lists reaches both notes, without a click" *
          doctest::skip(kSanitized)) {
  const Woodwind& wind = *woodwind(BoreEnd::kClarinet);
  const std::vector<double> lower = prepend_vent(1, standard(wind, 60)),
                            upper = prepend_vent(1, standard(wind, 62));
  Instrument instrument = make_instrument(clarinet());
  REQUIRE(instrument.finger_holes(lower));
  const std::size_t half = 48000 / 14; // 7 Hz
  std::vector<double> sound;
  double steady = 0;
  for (int turn = 0; turn < 14; ++turn) {
    const std::size_t size = turn == 0 ? 24000 : half;
    if (turn > 0)
      REQUIRE(instrument.finger_holes(turn % 2 == 1 ? upper : lower));
    const std::vector<double> mouth =
        turn == 0 ? ramp(2000, 0.5, 48000) : std::vector<double>(size, 2000.0);
    const Recording r = play(instrument, mouth, 48000, 0, 0);
    if (turn == 0) {
      steady = largest_step(part(r, r.sound, 0.3, 0.5));
    } else {
      CHECK(largest_step(r.sound) < 2 * steady);
      const double note = frequency_of(turn % 2 == 1 ? 62 : 60);
      const auto output = std::span(r.bore_pressure).subspan(half / 3);
      CHECK(std::abs(cents(pitch(output, 48000, 0.94 * note, 1.06 * note), note)) < 40);
    }
  }
}

TEST_CASE("the register vent takes the clarinet a twelfth up, and a slur over it does not click" *
          doctest::skip(kSanitized)) {
  const Parameters p = clarinet();
  CHECK(standard_fingering(p, frequency_of(68)) ==
        Fingering{fingering_for(p.end, frequency_of(68)), false});
  CHECK(standard_fingering(p, frequency_of(69)) ==
        Fingering{fingering_for(p.end, frequency_of(50)), true});
  CHECK(key_of(p, standard_fingering(p, frequency_of(75))) == 75);
  for (const int key : {70, 74, 78})
    for (const double pressure : {900.0, 2000.0, 5500.0}) {
      Instrument instrument = make_instrument(p);
      const double note = frequency_of(key);
      const Recording r = play(instrument, ramp(pressure, 1.2, 48000), 48000, 0, note);
      CAPTURE(key);
      CAPTURE(pressure);
      const NoteMeasure output = measure_note(r, note, 0.5, 1.2);
      CHECK(output.in_register());
      CHECK(std::abs(output.cents) < 10);
      CHECK(output.inharmonic_db < -30);
      // The tube is that of the note a twelfth below, not a short one.
      CHECK(instrument.length() > 0.8 * woodwind(p.end)->position(key - 19));
    }
  // The same tube with and without the vent.
  const Woodwind& wind = *woodwind(BoreEnd::kClarinet);
  for (const double vent : {1.0, 0.0}) {
    Instrument instrument = make_instrument(p);
    REQUIRE(instrument.finger_holes(prepend_vent(vent, standard(wind, 55))));
    const Recording r = play(instrument, ramp(2000, 1, 48000), 48000, 0, 0);
    const double note = frequency_of(vent > 0.5 ? 55 : 74);
    const auto output = part(r, r.bore_pressure, 0.5, 1);
    CHECK(std::abs(cents(pitch(output, 48000, 0.93 * note, 1.07 * note), note)) < 70);
    CHECK(measure_note(r, note, 0.5, 1).inharmonic_db < -30);
  }
  // Slurs over the break, up and down.
  Instrument instrument = make_instrument(p);
  double steady = 0;
  for (int turn = 0; turn < 5; ++turn) {
    const double note = frequency_of(turn % 2 == 0 ? 67 : 71);
    const std::vector<double> mouth =
        turn == 0 ? ramp(2000, 0.6, 48000) : std::vector<double>(28800, 2000.0);
    const Recording r = play(instrument, mouth, 48000, 0, note);
    CAPTURE(turn);
    const auto end = part(r, r.bore_pressure, 0.35, 0.6);
    CHECK(std::abs(cents(pitch(end, 48000, 0.93 * note, 1.07 * note), note)) < 10);
    if (turn < 2)
      steady = std::max(steady, largest_step(part(r, r.sound, 0.4, 0.6)));
    else
      CHECK(largest_step(r.sound) < 2 * steady);
  }
}

} // namespace tactus::reed

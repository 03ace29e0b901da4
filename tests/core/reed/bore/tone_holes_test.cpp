#include "core/dsp/complex.hpp"
#include "core/reed/bore/brass.hpp"
#include "core/reed/bore/hole_fingering.hpp"
#include "core/reed/bore/tone_hole_end.hpp"
#include "core/reed/instrument/tuning.hpp"
#include "core/reed/playability/linear_stability.hpp"
#include "tests/core/reed/bore/bell_reference.hpp"
#include "tests/core/reed/bore/bore_echo.hpp"
#include "tests/core/reed/bore/bore_reference.hpp"
#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

// Tone holes and bells: the bore that they end against independent solvers of the horn equation
// (bench/reed_bores), the digital filters against their rational functions, these against energy.

namespace tactus::reed {
namespace {

using namespace test;
constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr BoreEnd kWoodwinds[] = {BoreEnd::kClarinet, BoreEnd::kSaxophone, BoreEnd::kOboe};

const Termination& row(BoreEnd end, int key) {
  for (const Termination& one : terminations(end))
    if (one.key == key)
      return one;
  FAIL("no such fingering");
  return terminations(end).front();
}

Parameters bore_of(BoreEnd end) {
  const char* names[] = {"", "clarinet", "sax", "oboe", "trumpet", "trombone"};
  Parameters p = with_player(names[static_cast<int>(end)]);
  p.end = end;
  p.tube = true;
  if (brass_tube(end) != nullptr)
    p = with_brass_tube(p);
  p.cup_volume = 0; // the references have none
  return p;
}

Termination end_of(const ImpedanceReference& reference) {
  if (reference.fingering == "bell")
    return bells(reference.end).front();
  if (std::isdigit(reference.fingering.front()))
    return row(reference.end, std::stoi(reference.fingering));
  Termination found;
  REQUIRE(finger_holes(*woodwind(reference.end), state_of(reference.fingering), found));
  return found;
}

/// Every stride-th row of a table; the worst that the docs quote.
void compare_peaks(const std::string& what, std::string_view rows, bool vented, std::size_t stride,
                   const std::vector<double>& rates) {
  double worst_cents = 0, worst_db = 0;
  const auto references = read_references(rows);
  for (std::size_t i = 0; i < references.size(); i += stride) {
    const ImpedanceReference& reference = references[i];
    const Parameters p = bore_of(reference.end);
    const Termination end = end_of(reference);
    for (const double rate : rates) {
      const auto echo =
          echo_of(p, end, reference.length, rate, static_cast<std::size_t>(0.5 * rate), vented);
      for (const ImpedancePeak& peak : reference.peaks) {
        if (peak.level < 4) // a shoulder is no resonance
          continue;
        // Close to a cone's apex air flows to and fro without travelling, and its friction is not
        // in the line's G: what peaks of long waves (k r_0 < 0.55) are too high by. The vent's
        // friction is one number; the mode that it stops is far from its frequency.
        const double near_apex = kTwoPi * peak.hz / air_at(20).sound_speed * p.apex_distance;
        const bool lacks_friction = p.shape == BoreShape::kCone && near_apex < 0.55;
        const bool stopped = vented && &peak == &reference.peaks[0];
        const ImpedancePeak found = peak_near(p, echo, rate, peak.hz);
        const double error_cents = cents(found.hz, peak.hz), error_db = found.level - peak.level;
        INFO(what, " ", reference.fingering, " at ", rate, ": ", peak.hz, " Hz, found ", found.hz);
        CHECK(std::abs(error_cents) < (stopped ? 12 : 5));
        CHECK(std::abs(error_db) < (stopped ? 5 : vented ? 1.5 : lacks_friction ? 2.5 : 1));
        worst_cents = std::max(worst_cents, std::abs(error_cents));
        worst_db = std::max(worst_db, lacks_friction ? 0 : std::abs(error_db));
      }
    }
  }
  MESSAGE("worst ", what, ": ", worst_cents, " cents, ", worst_db, " dB");
}

void compare_all_peaks(std::size_t stride, const std::vector<double>& rates) {
  compare_peaks("standard fingering", kBoreReference, false, stride, rates);
  compare_peaks("state of the holes", kFingeredReference, false, stride, rates);
  compare_peaks("fingering with its vent open", kVentedReference, true, stride, rates);
  compare_peaks("bell", kBellReference, false, stride, rates);
}

/// Nothing is reflected more than arrives, at any frequency and rate; poles lie on the left; the
/// digital filter is the design's reflectance.
void check_termination(const Termination& one, const std::vector<double>& rates) {
  INFO("key ", one.key);
  const double at_rest = one.reflectance(0.0).value.real();
  CHECK(at_rest < -0.9);
  CHECK(at_rest >= -1);
  for (double hz = 0.01; hz < 1e6; hz *= 1.01)
    REQUIRE(abs(one.reflectance({0, kTwoPi * hz}).value) <= 1 + 1e-9);
  const auto poles_lie_left = [](const auto& blocks) {
    for (const Termination::Block& block : blocks)
      CHECK((block.a < 0 && (block.oscillates || block.b < 0)));
  };
  poles_lie_left(one.reflection);
  poles_lie_left(one.radiation);
  for (const double rate : rates)
    for (const double speed_ratio : {1.0, 1.03}) {
      DigitalReflection digital;
      digital.set(one.reflection, one.dc_value, rate, speed_ratio, 1);
      for (int i = 0; i <= 500; ++i)
        REQUIRE(abs(digital.at(tactus::math::polar(1.0, std::numbers::pi * i / 500))) <= 1 + 1e-9);
      for (double f = 60; f < 4000 && rate > 40e3 && speed_ratio == 1; f *= 1.05)
        CHECK(abs(digital.at(tactus::math::polar(1.0, -kTwoPi * f / rate)) -
                  one.reflectance({0, kTwoPi * f}).value) < 0.031);
    }
}

/// All bells, every stride-th standard fingering and so many random states of the holes.
void check_terminations(std::size_t stride, int states, const std::vector<double>& rates) {
  for (const BoreEnd end : {BoreEnd::kTrumpet, BoreEnd::kTrombone})
    check_termination(bells(end).front(), rates);
  std::mt19937 random(7);
  const auto between_0_and_1 = [&] { return static_cast<double>(random() % 1000) / 999; };
  for (const BoreEnd end : kWoodwinds) {
    for (std::size_t i = 0; i < terminations(end).size(); i += stride)
      check_termination(terminations(end)[i], rates);
    for (int i = 0; i < states; ++i) {
      std::vector<double> closed(woodwind(end)->tone_holes());
      for (double& hole : closed) {
        const double x = between_0_and_1();
        hole = x < 0.4 ? 1 : x < 0.7 ? 0 : between_0_and_1();
      }
      Termination found;
      REQUIRE(finger_holes(*woodwind(end), closed, found));
      check_termination(found, rates);
    }
  }
}

} // namespace

TEST_CASE("bores with holes, vent or bell resonate where independent solvers say, and as high") {
  compare_all_peaks(5, {44100});
}

TEST_CASE("every bore with holes, vent or bell resonates where independent solvers say" *
          doctest::test_suite("slow")) {
  compare_all_peaks(1, {44100, 48000, 96000});
}

TEST_CASE("neither holes nor bells reflect more than arrives, and their filters are as designed") {
  check_terminations(7, 1, {8000, 44100});
}

TEST_CASE("no fingering at all reflects more than arrives, and its filters are as designed" *
          doctest::test_suite("slow")) {
  check_terminations(1, 20, {8000, 22050, 32000, 44100, 48000, 96000, 192000});
}

TEST_CASE("the sections compute the response that the design says") {
  const Termination& one = row(BoreEnd::kClarinet, 55); // has real and complex poles
  CHECK(std::any_of(one.reflection.begin(), one.reflection.end(),
                    [](const auto& block) { return !block.oscillates; }));
  const double rate = 48000;
  DigitalReflection digital;
  digital.set(one.reflection, one.dc_value, rate, 1.02, 1);
  TerminationFilter<double, Termination::kReflectionBlocks> filter;
  std::vector<double> response(12000);
  {
    decltype(filter)::BlockFilter stretch(filter, digital);
    for (std::size_t n = 0; n < response.size(); ++n)
      response[n] = stretch(n == 0 ? 1.0 : 0.0);
  }
  for (const double hz : {20.0, 300.0, 1700.0, 9000.0}) {
    const Complex back = tactus::math::polar(1.0, -kTwoPi * hz / rate);
    Complex sum = 0, turn = 1;
    for (const double x : response) {
      sum += x * turn;
      turn *= back;
    }
    CHECK(abs(sum - digital.at(back)) < 1e-6);
    CHECK(abs(sum - one.reflectance({0, kTwoPi * hz / 1.02}).value) < 0.04);
  }
  CHECK(abs(digital.at(1.0) - one.dc_value) < 1e-9);
  // The derivative, by differences.
  const Complex s(-20, 5000), small(1e-3, 0);
  const Complex slope =
      (one.reflectance(s + small).value - one.reflectance(s - small).value) / 2e-3;
  CHECK(abs(one.reflectance(s).derivative - slope) < 1e-6 * abs(slope));
}

TEST_CASE("holes are heard as a point source below the cut-off, and let all power out above") {
  for (const int key : {51, 57, 63, 69}) {
    DigitalRadiation radiation;
    radiation.set(row(BoreEnd::kClarinet, key).radiation, 0, 192000, 1, 7.5e-3);
    const double speed = air_at(20).sound_speed;
    // The doubled flow 2 a S/(rho c) as a point source at 1 m: a r/2 k r.
    const double hz = 150, low = 7.5e-3 / 2 * kTwoPi * hz / speed * 7.5e-3;
    const double output = abs(radiation.at(tactus::math::polar(1.0, -kTwoPi * hz / 192000)));
    CHECK(std::abs(20 * std::log10(output / low)) < 0.5);
    // All of a^2 S/(2 rho c) over 4 pi m^2: a r/2.
    const double high = abs(radiation.at(tactus::math::polar(1.0, -kTwoPi * 5000 / 192000)));
    CHECK(std::abs(20 * std::log10(high / (7.5e-3 / 2))) < 2);
    CHECK(abs(radiation.at(1.0)) < 1e-9);
  }
}

TEST_CASE("a new fingering is there after 5 ms, and nothing grows on the way") {
  ToneHoleEnd<double> holes, fresh;
  for (auto* one : {&holes, &fresh})
    one->set(48000, 1, 7.5e-3);
  holes.finger(&row(BoreEnd::kClarinet, 51));
  holes.finger(&row(BoreEnd::kClarinet, 67));
  holes.start_pending_fade();
  fresh.finger(&row(BoreEnd::kClarinet, 67));
  double largest = 0;
  for (int n = 0; n < 4800; ++n) {
    double one = std::sin(0.02 * n) + 0.3 * std::sin(0.21 * n), other = one;
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

TEST_CASE("a tuned bore with holes has its threshold at the note, and the player has its lips") {
  for (const BoreEnd end : kWoodwinds)
    for (const double f : {180.0, 260.0, 350.0}) {
      const Parameters p = bore_of(end);
      const Termination* fingering = fingering_for(end, f);
      REQUIRE(fingering != nullptr);
      const double length = tuned_length(p, f, p.reed_frequency, 1, {fingering, false});
      // The threshold of the mode that tune meant, found by another road.
      const Threshold found = LinearStability(p, length, fingering).threshold(p.reed_frequency, f);
      INFO("end ", static_cast<int>(end), ", ", f, " Hz");
      if (found.found)
        CHECK(std::abs(cents(found.frequency_hz, f)) < 1);
    }
  Parameters p = with_player("clarinet");
  p.lip_channel = 2.5;
  CHECK(tuned(p, 200, 2500).valve.channel_length == doctest::Approx(2.5 * p.channel_length));
  CHECK(tuned(p, 200, 2500).fingering.end == fingering_for(BoreEnd::kClarinet, 200));
  CHECK(embouchure_for(p, 200, 0.4).fingering.end == fingering_for(BoreEnd::kClarinet, 200));
}

TEST_CASE("a note takes the nearest fingering, whose length the ideal frequency leaves out") {
  CHECK(fingering_for(BoreEnd::kOpen, 200) == nullptr);
  CHECK(fingering_for(BoreEnd::kClarinet, 10)->key == 50);
  CHECK(fingering_for(BoreEnd::kClarinet, 1e5)->key == 70);
  for (const double semitones : {-0.45, 0.0, 0.45})
    CHECK(fingering_for(BoreEnd::kClarinet, hertz(60 + semitones))->key == 60);
  for (const BoreEnd end : kWoodwinds) {
    const Parameters p = bore_of(end);
    BoreDesign bore;
    bore.set(p, 48000);
    const Termination* fingering = fingering_for(end, 262);
    bore.set_end(fingering);
    const double length = bore.length_for(262);
    CHECK(bore.ideal_frequency(length) == doctest::Approx(262));
    if (end != BoreEnd::kClarinet) // a shut cone without its tip's volume resonates elsewhere
      continue;
    // Wall friction alone is between it and the resonance of theory.
    const Mode mode = LinearStability(p, length, fingering).bore_resonance_near(262);
    CHECK(mode.found);
    CHECK(std::abs(cents(mode.frequency_hz, 262)) < 35);
  }
}

TEST_CASE("a bend of 70 cents keeps its fingering, and a semitone takes the next") {
  const Parameters p = with_player("clarinet");
  Player player = make_player(p);
  const auto end_at = [&](double cents) {
    return player.control(220 * std::exp2(cents / 1200), p.reed_frequency, 2000).end;
  };
  const Termination* const end = end_at(0);
  REQUIRE(end != nullptr);
  for (int cents = 10; cents <= 70; cents += 10)
    CHECK(end_at(cents) == end);
  CHECK(end_at(100)->key == end->key + 1);
}

} // namespace tactus::reed

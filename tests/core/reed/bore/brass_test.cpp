#include "core/reed/bore/brass.hpp"

#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

// Trumpet and trombone: what valves and slide make of the tube. Resonances with the bell are
// compared in tone_holes_test.cpp, notes in player/compass_test.cpp.

namespace tactus::reed {
namespace {

using namespace test;
constexpr BoreEnd kBells[] = {BoreEnd::kTrumpet, BoreEnd::kTrombone};

Parameters brass(BoreEnd end) {
  Parameters p = with_player(end == BoreEnd::kTrumpet ? "trumpet" : "trombone");
  p.tube = true;
  p.end = end;
  return p;
}

} // namespace

TEST_CASE("slide positions are semitones, and valves together lower by less than their sum") {
  for (const BoreEnd end : kBells) {
    const BrassTube& tube = *brass_tube(end);
    const Termination& bell = bells(end).front();
    const double beyond = bell.length_correction(), open = tube.open_length + beyond;
    const auto lowered = [&](double length) { return cents(length + beyond, open) / 100; };
    CHECK(bells(end).size() == 1);
    CHECK(slide_length(tube, bell, 1) == tube.open_length);
    for (const double position : {2.0, 3.5, 7.0})
      CHECK(lowered(slide_length(tube, bell, position)) == doctest::Approx(position - 1));
    CHECK(valve_length(tube, bell, 0) == tube.open_length);
    CHECK(lowered(valve_length(tube, bell, 1)) == doctest::Approx(2));
    CHECK(lowered(valve_length(tube, bell, 2)) == doctest::Approx(1));
    CHECK(lowered(valve_length(tube, bell, 4)) == doctest::Approx(3));
    // Three tubes cut for 2, 1 and 3 semitones of the open one: 5.5 semitones.
    const double all =
        12 * std::log2(std::exp2(2 / 12.0) + std::exp2(1 / 12.0) + std::exp2(3 / 12.0) - 2);
    CHECK(lowered(valve_length(tube, bell, 7)) == doctest::Approx(all));
  }
}

TEST_CASE("players take the usual valves and positions") {
  const BrassTube& trumpet = *brass_tube(BoreEnd::kTrumpet);
  // Sounding pitch; every beginner's table: low F sharp 123, C 0, D 13, E 12, F 1, F sharp 2, G 0.
  for (const auto& [key, valves] :
       {std::pair{52, 7U}, {58, 0U}, {60, 5U}, {62, 3U}, {63, 1U}, {64, 2U}, {65, 0U}, {70, 0U}})
    CHECK(standard_valves(static_cast<int>(standard_positions(trumpet, hertz(key)).semitones)) ==
          valves);
  const BrassTube& trombone = *brass_tube(BoreEnd::kTrombone);
  for (const auto& [key, position] : {std::pair{40, 7}, {46, 1}, {48, 6}, {53, 1}}) // E2 C3 F3
    CHECK(1 + standard_positions(trombone, hertz(key)).semitones ==
          doctest::Approx(position).epsilon(0.02));
}

TEST_CASE("the tube's naturals are its modes near the target, and longer tubes have lower ones") {
  for (const BoreEnd end : kBells) {
    const BrassTube& tube = *brass_tube(end);
    const Termination& bell = bells(end).front();
    const Parameters played = with_brass_tube(brass(end));
    for (int natural = 2; natural <= 8; ++natural) {
      const double target = natural * tube.fundamental;
      const double open = nearest_natural(played, bell, tube.open_length, target);
      const double longer =
          nearest_natural(played, bell, slide_length(tube, bell, 2), target / 1.0595);
      INFO("natural ", natural, " of ", static_cast<int>(end));
      // A cylinder of three quarters of the length: the lowest modes lie flat, as measured ones do.
      CHECK(std::abs(cents(open, target)) < (natural == 2 ? 95 : 60));
      CHECK(std::abs(cents(longer, open) + 100) < 35);
    }
  }
}

TEST_CASE("valves that are held choose the tube whatever the note, and else the player does") {
  const auto length = [](int valves, double target) {
    Parameters p = brass(BoreEnd::kTrumpet);
    p.tube = false;
    p.valves = valves;
    Instrument instrument = make_instrument(p);
    play(instrument, ramp(1000, 0.05, 48000), 48000, 0, target);
    return instrument.length();
  };
  const BrassTube& tube = *brass_tube(BoreEnd::kTrumpet);
  const Termination& bell = bells(BoreEnd::kTrumpet).front();
  for (const int valves : {0, 2, 5, 7})
    for (const double target : {233.0, 466.0})
      CHECK(length(valves, target) ==
            doctest::Approx(valve_length(tube, bell, static_cast<unsigned>(valves))));
  CHECK(length(-1, 233) != doctest::Approx(length(-1, 466)));
}

} // namespace tactus::reed

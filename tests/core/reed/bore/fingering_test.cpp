#include "core/dsp/complex.hpp"
#include "core/reed/bore/hole_fingering.hpp"
#include "core/reed/bore/register_vent.hpp"
#include "core/reed/instrument/tuning.hpp"
#include "tests/core/reed/bore/bore_echo.hpp"
#include "tests/core/reed/bore/bore_reference.hpp"
#include "tests/core/reed/note_measure.hpp"
#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

// Holes fingered one by one, and the register vent: filters against energy, notes against their
// bores. Their resonances are compared in tone_holes_test.cpp.

namespace tactus::reed {
namespace {

using namespace test;
constexpr double kTwoPi = 2 * std::numbers::pi;

/// The standard fingering: what is above the note's first open hole is closed.
std::vector<double> standard(const Woodwind& wind, int key) {
  std::vector<double> closed(wind.tone_holes(), 0);
  for (std::size_t i = 0; i < closed.size(); ++i)
    closed[i] = wind.key_of(i) > key ? 1 : 0;
  return closed;
}

Parameters clarinet() {
  Parameters p = with_player("clarinet");
  p.register_note = 440;
  return p;
}

const Woodwind& clarinet_bore() { return *woodwind(BoreEnd::kClarinet); }

/// With the register vent in front.
std::vector<double> prepend_vent(double vent, std::vector<double> holes) {
  holes.insert(holes.begin(), vent);
  return holes;
}

/// Hz that a fingering with closed vent sounds; 0: nothing within 12 % of near.
double sounding_pitch(const std::vector<double>& holes, double near_hz) {
  Instrument instrument = make_instrument(clarinet());
  REQUIRE(instrument.finger_holes(prepend_vent(1, holes)));
  const Recording r = play(instrument, ramp(2000, 0.7, 48000), 48000);
  const auto output = part(r, r.bore_pressure, 0.4, 0.7);
  return rms(output) > 100 ? pitch(output, 48000, 0.89 * near_hz, 1.12 * near_hz) : 0;
}

struct NoLosses {
  double incident(double x) const { return x; }
} no_losses;

} // namespace

TEST_CASE("standard fingerings come out as the tables have them") {
  for (const BoreEnd end : {BoreEnd::kClarinet, BoreEnd::kSaxophone, BoreEnd::kOboe})
    for (const Termination& table : terminations(end)) {
      if (table.key % 8 != 0)
        continue;
      const Woodwind& wind = *woodwind(end);
      Termination found;
      REQUIRE(finger_holes(wind, standard(wind, table.key), found));
      INFO("end ", static_cast<int>(end), ", key ", table.key);
      CHECK(found.key == table.key);
      DigitalRadiation one, other;
      one.set(found.radiation, 0, 192000, 1, 1);
      other.set(table.radiation, 0, 192000, 1, 1);
      for (double hz = 60; hz < 0.8 * wind.cutoff; hz *= 1.02) {
        const Complex s(0, kTwoPi * hz);
        CHECK(abs(found.reflectance(s).value - table.reflectance(s).value) < 0.02);
        const Complex back = tactus::math::polar(1.0, -kTwoPi * hz / 192000);
        CHECK(std::abs(20 * std::log10(abs(one.at(back) / other.at(back)))) < 2.5);
      }
    }
}

TEST_CASE("fingerings are kept, and refused where they are none") {
  HoleFingerings cache;
  const auto low = standard(clarinet_bore(), 60), high = standard(clarinet_bore(), 62);
  const Termination* const first = cache.find(BoreEnd::kClarinet, low);
  REQUIRE(first != nullptr);
  const Termination* const second = cache.find(BoreEnd::kClarinet, high);
  CHECK(second != first);
  CHECK(second->key == 62);
  CHECK(cache.find(BoreEnd::kClarinet, low) == first);
  CHECK(cache.find(BoreEnd::kOboe, low) == nullptr);
  CHECK(cache.find(BoreEnd::kOpen, {}) == nullptr);
  Instrument instrument = make_instrument(clarinet());
  std::vector<double> holes(21, 1);
  CHECK(instrument.finger_holes(holes));
  for (const double wrong : {std::nan(""), 1.5}) {
    holes[3] = wrong;
    CHECK_FALSE(instrument.finger_holes(holes));
  }
  CHECK_FALSE(instrument.finger_holes(std::span(holes).first(5)));
  CHECK_FALSE(instrument.finger_holes({}));
}

TEST_CASE("the vent gains no power, however far it is open, and passes less of a large wave") {
  const RegisterVent design = RegisterVent::of(clarinet());
  for (const double open : {0.0, 0.3, 1.0}) {
    VentFilter<double> vent;
    vent.set(design, 48000);
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 800);
    double in = 0, out = 0;
    for (int n = 0; n < 20000; ++n) {
      double above = n < 15000 ? noise(random) : 0, below = n < 15000 ? noise(random) : 0;
      in += above * above + below * below;
      vent.pass(no_losses, &above, &below, {open, 0}, 1);
      out += above * above + below * below;
      REQUIRE(out <= in * (1 + 1e-12));
    }
    CHECK((out < 0.999 * in) == (open > 0));
  }
  // Small waves: H. Large ones meet the jet's loss, and less goes through.
  for (const double hz : {150.0, 600.0, 2000.0}) {
    double through[2];
    for (const double size : {1e-3, 3e3}) {
      VentFilter<double> vent;
      vent.set(design, 192000);
      Complex sum = 0;
      for (int n = 0; n < 38400; ++n) { // whole periods in its second half
        double above = size * std::cos(kTwoPi * hz * n / 192000), below = 0;
        const double a = above;
        vent.pass(no_losses, &above, &below, {1, 0}, 1);
        if (n >= 19200)
          sum += (a - below) * tactus::math::polar(2.0 / 19200 / size, -kTwoPi * hz * n / 192000);
      }
      through[size > 1] = abs(sum);
    }
    CHECK(through[0] == doctest::Approx(abs(design.at({0, kTwoPi * hz}))).epsilon(0.02));
    CHECK(through[1] < (hz < 1000 ? 0.95 : 1) * through[0]); // above, mass alone counts
  }
}

TEST_CASE("theory undoes what the vent does") {
  const RegisterVent vent = RegisterVent::of(clarinet());
  const Complex s(0, kTwoPi * 500), vent_path = tactus::math::polar(0.97, -1.3),
                                    below = tactus::math::polar(0.9, 2.1);
  // What comes back above a vent from what comes back below it.
  const Complex h = vent.at(s), b = below * (1.0 - h) / (1.0 + h * below);
  const Complex up = b - h * (1.0 + b);
  CHECK(abs(vent.without_vent(s, vent_path * up, vent_path) - vent_path * below) < 1e-12);
}

TEST_CASE("cross fingerings and half holes sound as their bores say") {
  // First resonances by finite elements: of forks, and of the same first open hole with all open
  // beyond it, by the line as it runs.
  const auto references = read_references(kFingeredReference);
  Termination end;
  REQUIRE(finger_holes(clarinet_bore(), standard(clarinet_bore(), 62), end));
  const Parameters p = find_preset("clarinet").value();
  const auto echo = echo_of(p, end, clarinet_bore().position(62), 48000, 24000);
  const double plain_peak = peak_near(p, echo, 48000, 281.7).hz;
  const double plain = sounding_pitch(state_of("ccccccccoooooooooooo"), hertz(62));
  CHECK(std::abs(cents(plain, hertz(62))) < 35); // the standard fingering
  for (const std::string_view fork : {"ccccccccoccooooooooo", "ccccccccoccccooooooo"}) {
    const auto reference =
        std::find_if(references.begin(), references.end(),
                     [fork](const ImpedanceReference& one) { return one.fingering == fork; });
    REQUIRE(reference != references.end());
    const double lower = cents(reference->peaks[0].hz, plain_peak);
    CHECK(lower < -20);
    CHECK(std::abs(cents(sounding_pitch(state_of(fork), hertz(62)), plain) - lower) < 25);
  }
  // Covering a hole step by step lowers the note step by step.
  double before = 1e9;
  for (const std::string_view holes : {"ccccccccccoooooooooo", "cccccccccchooooooooo",
                                       "ccccccccccqooooooooo", "cccccccccccooooooooo"}) {
    const double output = sounding_pitch(state_of(holes), hertz(59.5));
    CHECK(output > 0);
    CHECK(output < before);
    before = output;
  }
}

TEST_CASE("a trill between two lists reaches both notes, without a click") {
  const std::vector<double> lower = prepend_vent(1, standard(clarinet_bore(), 60)),
                            upper = prepend_vent(1, standard(clarinet_bore(), 62));
  Instrument instrument = make_instrument(clarinet());
  REQUIRE(instrument.finger_holes(lower));
  const Recording first = play(instrument, ramp(2000, 0.5, 48000), 48000);
  const double steady = largest_step(part(first, first.sound, 0.3, 0.5));
  const std::size_t half = 48000 / 14; // 7 Hz
  for (int turn = 1; turn < 8; ++turn) {
    REQUIRE(instrument.finger_holes(turn % 2 == 1 ? upper : lower));
    const Recording r = play(instrument, std::vector<double>(half, 2000.0), 48000);
    CHECK(largest_step(r.sound) < 2 * steady);
    const double note = hertz(turn % 2 == 1 ? 62 : 60);
    const auto output = std::span(r.bore_pressure).subspan(half / 3);
    CHECK(std::abs(cents(pitch(output, 48000, 0.94 * note, 1.06 * note), note)) < 40);
  }
}

TEST_CASE("the register vent takes the clarinet a twelfth up, and a slur over it does not click") {
  const Parameters p = clarinet();
  CHECK(standard_fingering(p, hertz(68)) == Fingering{fingering_for(p.end, hertz(68)), false});
  CHECK(standard_fingering(p, hertz(69)) == Fingering{fingering_for(p.end, hertz(50)), true});
  CHECK(key_of(p, standard_fingering(p, hertz(75))) == 75);
  for (const int key : {70, 74, 78}) {
    Instrument instrument = make_instrument(p);
    const double pressure = key == 70 ? 900 : key == 74 ? 5500 : 2000;
    const Recording r = play(instrument, ramp(pressure, 1.2, 48000), 48000, 0, hertz(key));
    const NoteMeasure output = measure_note(r, hertz(key), 0.5, 1.2);
    INFO("key ", key);
    CHECK(output.in_register());
    CHECK(std::abs(output.cents) < 10);
    CHECK(output.inharmonic_db < -30);
    // The tube is that of the note a twelfth below, not a short one.
    CHECK(instrument.length() > 0.8 * clarinet_bore().position(key - 19));
  }
  // The same tube with and without the vent.
  for (const double vent : {1.0, 0.0}) {
    Instrument instrument = make_instrument(p);
    REQUIRE(instrument.finger_holes(prepend_vent(vent, standard(clarinet_bore(), 55))));
    const Recording r = play(instrument, ramp(2000, 1, 48000), 48000);
    const NoteMeasure output = measure_note(r, hertz(vent > 0.5 ? 55 : 74), 0.5, 1);
    CHECK(std::abs(output.cents) < 70);
    CHECK(output.inharmonic_db < -30);
  }
  // Slurs over the break, up and down.
  Instrument instrument = make_instrument(p);
  double steady = 0;
  for (int turn = 0; turn < 4; ++turn) {
    const double note = hertz(turn % 2 == 0 ? 67 : 71);
    const std::vector<double> mouth =
        turn == 0 ? ramp(2000, 0.6, 48000) : std::vector<double>(28800, 2000.0);
    const Recording r = play(instrument, mouth, 48000, 0, note);
    const auto end = part(r, r.bore_pressure, 0.35, 0.6);
    INFO("turn ", turn);
    CHECK(std::abs(cents(pitch(end, 48000, 0.93 * note, 1.07 * note), note)) < 10);
    if (turn < 2)
      steady = std::max(steady, largest_step(part(r, r.sound, 0.4, 0.6)));
    else
      CHECK(largest_step(r.sound) < 2 * steady);
  }
}

} // namespace tactus::reed

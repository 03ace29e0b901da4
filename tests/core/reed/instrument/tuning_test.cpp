#include "core/dsp/complex.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/instrument/tuning.hpp"
#include "core/reed/playability/linear_stability.hpp"
#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

namespace tactus::reed {
namespace {

using namespace test;

// Where the resonance near `near_hz` starts to play; or, where it never grows, where it decays the
// slowest: the threshold search of linear theory, which knows nothing of the tuning's way.
double playing_frequency(const LinearStability& theory, double reed_frequency, double near_hz) {
  const Threshold threshold = theory.threshold(reed_frequency, near_hz);
  if (threshold.found)
    return threshold.frequency_hz;
  const double start = theory.bore_resonance_near(near_hz).frequency_hz;
  Mode best;
  for (int i = 1; i <= 24; ++i) {
    const double pressure = theory.highest_pressure(reed_frequency) * i / 24;
    const Mode mode = theory.mode_near(pressure, reed_frequency, start);
    if (mode.found && (!best.found || mode.growth_rate > best.growth_rate))
      best = mode;
  }
  return best.frequency_hz;
}

TEST_CASE("the tuned bore has its linear playing frequency at f_b") {
  for (const char* name : {"clarinet", "sax", "oboe"})
    for (const double f : {110.0, 175.0, 262.0, 392.0}) {
      const Parameters p = find_preset(name).value();
      const double length = tuned_length(p, f, p.reed_frequency);
      INFO(std::string(name), ", ", f, " Hz");
      const double linear = playing_frequency(LinearStability(p, length), p.reed_frequency, f);
      CHECK(std::abs(cents(linear, f)) < 1);
    }
}

TEST_CASE("above its threshold a tuned bore sends back in phase what the valve would play on") {
  // At so many times the threshold valve and bore agree in the phase of the round trip alone: the
  // note grows. (1 - y)/(1 + y), y = Z_0 (Y - what lies at the input: cup and cone).
  for (const char* name : {"clarinet", "sax"})
    for (const double f : {147.0, 262.0})
      for (const double over : {1.0, 1.5, 1.7}) { // half way to the highest at most
        const Parameters p = find_preset(name).value();
        const double reed = p.reed_frequency;
        const LinearStability first(p, tuned_length(p, f, reed));
        const double threshold = first.threshold(reed, f).mouth_pressure;
        REQUIRE(threshold > 0);
        const LinearStability theory(p, tuned_length(p, f, reed, over));
        const Complex s(0, 2 * std::numbers::pi * f);
        const double area = std::numbers::pi * p.input_radius * p.input_radius;
        const double speed = 331.45 * std::sqrt(1 + 20 / 273.15);
        const double density = 1.2929 * 273.15 / 293.15;
        const Complex lumped =
            s * p.cup_volume / (density * speed * speed) +
            (p.shape == BoreShape::kCone ? area / (s * density * p.apex_distance) : Complex(0));
        const auto round_trip = [&](Complex admittance) {
          const Complex y = density * speed / area * (admittance - lumped);
          return (1.0 - y) / (1.0 + y);
        };
        const Complex valve = round_trip(
            theory.valve_admittance(s, theory.equilibrium(over * threshold, reed), reed));
        const Complex bore = round_trip(theory.input_admittance(s));
        INFO(std::string(name), ", ", f, " Hz, ", over, " times the threshold");
        CHECK(std::abs(arg(valve / bore)) < 2e-3); // of a turn of 2 pi: half a cent
        if (over == 1.0)
          CHECK(abs(valve / bore) == doctest::Approx(1).epsilon(2e-3));
      }
}

TEST_CASE("a player tunes reeds at one and a half times the threshold, lips at two and a half") {
  for (const char* name : {"clarinet", "oboe", "trumpet", "trombone"}) {
    Parameters p = find_preset(name).value();
    p.aim = 20;
    p.lip_cup = 0.7;
    const double f = std::string(name) == "trombone" ? 147 : 262, aimed = f * std::exp2(20 / 1200.);
    const double reed = p.reed_frequency;
    const PlayingSetup playing = tuned(p, f, reed);
    const bool lips = p.embouchure > 0;
    const double embouchure = p.embouchure * std::pow(aimed / reed, p.embouchure_slope);
    CAPTURE(name);
    CHECK(playing.length ==
          doctest::Approx(tuned_length(playing.valve, aimed, lips ? embouchure * aimed : reed,
                                       lips ? 2.5 : 1.5, playing.fingering))
              .epsilon(1e-9)
              .scale(0));
    // The lips go with the note at constant stiffness m w^2: f_r of the note, not of the table.
    const double scale = lips ? embouchure * aimed / reed : 1;
    CHECK(playing.reed_scale == doctest::Approx(scale));
    // A reed opens with the note's power of f_b/f_r at the same closing pressure k x_0.
    const double opened = lips ? 1 : std::pow(aimed / reed, p.embouchure_slope);
    CHECK((opened > 5) == (std::string(name) == "oboe"));
    CHECK(playing.valve.mass ==
          doctest::Approx(p.mass * p.lip_mass / (scale * scale * opened)).scale(0));
    CHECK(playing.valve.rest_angle ==
          doctest::Approx(p.rest_angle * p.lip_opening * opened).scale(0));
    CHECK(playing.valve.cup_volume == p.cup_volume * p.lip_cup);
    CHECK(playing.valve.width == doctest::Approx(p.width * p.lip_width).scale(0));
    CHECK(playing.valve.quality == doctest::Approx(p.quality * p.lip_quality).scale(0));
  }
}

TEST_CASE("tuning absurd instruments ends and gives a usable length") {
  for (const Preset& preset : presets())
    for (const double f : {8.0, 4000.0})
      for (const double reed : {1.0, 20000.0}) {
        const double length = tuned_length(preset.parameters, f, reed);
        CHECK(length >= 5e-3);
        CHECK(length < 30);
      }
}

} // namespace
} // namespace tactus::reed

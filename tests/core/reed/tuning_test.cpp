#include "core/reed/bore_design.hpp"
#include "core/reed/linear_stability.hpp"
#include "core/reed/presets.hpp"
#include "core/reed/tuning.hpp"
#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <cmath>

namespace tactus::reed {
namespace {

using namespace test;

TEST_CASE("the tuned bore has its linear playing frequency at f_b") {
  for (const char* name : {"clarinet", "sax", "oboe"})
    for (const double f : {110.0, 175.0, 262.0, 392.0}) {
      const Parameters p = find_preset(name).value();
      const double length = tuned_length(p, f, p.reed_frequency);
      CAPTURE(name);
      CAPTURE(f);
      // The threshold search of linear theory, which knows nothing of the tuning's way.
      const double linear = linear_playing_frequency(p, length, p.reed_frequency, f);
      CHECK(std::abs(cents(linear, f)) < 1);
    }
}

TEST_CASE("a tuned clarinet plays its note, an untuned one is flat") {
  for (const double f : {110.0, 147.0, 196.0, 262.0, 349.0}) {
    Parameters p = find_preset("clarinet").value();
    double heard[2];
    for (const bool tune : {false, true}) {
      p.tune = tune;
      Instrument instrument;
      instrument.set(p);
      instrument.prepare(48000, 64);
      const Recording r = play(instrument, ramp(2000, 1.5, 48000), 48000, 0, f);
      heard[tune] = pitch(part(r, r.bore_pressure, 0.8, 1.5), 48000, 0.8 * f, 1.2 * f);
    }
    CAPTURE(f);
    CHECK(cents(heard[0], f) < -30);
    CHECK(std::abs(cents(heard[1], f)) < 15);
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

#include "core/reed/bore/radiation_path.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/instrument/tuning.hpp"
#include "core/reed/player/tuning_controller.hpp"
#include "tests/core/reed/render.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

namespace tactus::reed {
namespace {

using namespace test;
constexpr double kPi = std::numbers::pi;

struct Tune {
  const char* preset;
  double pressure;
  std::vector<double> notes; // Hz
};

/// A note after `settle` seconds, as cents from the one meant.
double pitch_error(const char* preset, double pressure, double note, double rate,
                   double settle = 0.6) {
  Parameters p = find_preset(preset).value();
  p.tune = true;
  Instrument instrument;
  instrument.set(p);
  instrument.prepare(rate, 64);
  const Recording r = play(instrument, ramp(pressure, settle + 0.7, rate), rate, 0, note);
  const auto output = part(r, r.bore_pressure, settle, settle + 0.7);
  CHECK(rms(output) > 100);
  return cents(pitch(output, rate, 0.95 * note, 1.05 * note), note);
}

TEST_CASE("with tune every sustained note lies within 10 cents, at any sample rate" *
          doctest::skip(kSanitized)) {
  const Tune tunes[] = {{"clarinet", 2000, {147, 233, 349}}, {"clarinet", 3000, {175, 262, 440}},
                        {"sax", 2000, {175, 233, 349}},      {"sax", 2500, {233, 294}},
                        {"oboe", 2000, {262, 330, 587}},     {"trumpet", 3000, {196, 233, 392}},
                        {"trumpet", 5000, {233, 294, 523}},  {"trombone", 2000, {117, 147, 175}},
                        {"trombone", 3000, {117, 147, 196}}, {"voice", 2500, {131, 175}},
                        {"syrinx", 600, {880, 1100}}};
  for (const double rate : {44100.0, 48000.0, 96000.0})
    for (const Tune& tune : tunes)
      for (const double note : tune.notes) {
        CAPTURE(rate);
        CAPTURE(std::string(tune.preset));
        CAPTURE(tune.pressure);
        CAPTURE(note);
        CHECK(std::abs(pitch_error(tune.preset, tune.pressure, note, rate)) < 10);
      }
}

TEST_CASE("a tuned note has the same bits however the stream is cut") {
  Parameters p = find_preset("trumpet").value();
  p.tune = true;
  const std::vector<double> mouth = ramp(4000, 0.5, 48000);
  const std::size_t size = mouth.size();
  const std::vector<double> reed(size, 0.0), bore(size, 262.0);
  std::vector<double> sound[2], theta(size), pressure(size), flow(size);
  for (int variant = 0; variant < 2; ++variant) {
    sound[variant].resize(size);
    Instrument instrument;
    instrument.set(p);
    instrument.prepare(48000, 64);
    const auto block = [variant](std::size_t at) { return variant == 0 ? 64 : 1 + at * 7 % 83; };
    for (std::size_t at = 0, n = 0; at < size; at += n) {
      n = std::min(block(at), size - at);
      const auto in = [&](const std::vector<double>& x) {
        return std::span<const double>(x.data() + at, n);
      };
      const auto out = [&](std::vector<double>& x) { return std::span<double>(x.data() + at, n); };
      instrument.process<double>({in(mouth), in(reed), in(bore)},
                                 {out(sound[variant]), out(theta), out(pressure), out(flow)});
    }
  }
  CHECK(sound[0] == sound[1]);
}

TEST_CASE("the ear hears a detuned sine and asks for its opposite") {
  // Open loop: the trim runs away at the rate of the integral controller, -error/0.1 s.
  for (const double detuned : {-0.02, -0.001, 0.001, 0.02}) {
    TuningController controller;
    controller.prepare(48000);
    controller.set_target(220);
    double trim = 0, at_start = 0;
    for (int i = 0; i < 14400; i += TuningController::kPeriod) {
      double pressure[TuningController::kPeriod];
      for (int k = 0; k < TuningController::kPeriod; ++k) {
        const double turn = 2 * kPi * 220 * (1 + detuned) * (i + k) / 48000;
        pressure[k] = 500 * std::sin(turn) + 400 * std::sin(2 * turn + 1) + 200;
      }
      controller.track_pitch(pressure, TuningController::kPeriod);
      controller.update();
      trim = controller.trim();
      if (i == 9600) // after the haste of a note's beginning
        at_start = trim;
    }
    // 0.1 s later; a tenth for the ripple of the partials at that moment.
    CHECK(trim - at_start == doctest::Approx(-detuned * 0.1 / 0.1).epsilon(0.1));
  }
}

TEST_CASE("the ear keeps still in silence, in noise of no pitch and for another register") {
  TuningController controller;
  controller.prepare(48000);
  controller.set_target(220);
  for (const double pitch : {0.0, 330.0, 660.0, 3000.0}) {
    for (int i = 0; i < 48000; i += TuningController::kPeriod) {
      double pressure[TuningController::kPeriod];
      for (int k = 0; k < TuningController::kPeriod; ++k)
        pressure[k] = 800 * std::sin(2 * kPi * pitch * (i + k) / 48000);
      controller.track_pitch(pressure, TuningController::kPeriod);
      controller.update();
    }
    CHECK(std::abs(controller.trim()) < 0.01); // a sixth of a semitone, from the beginnings
  }
}

TEST_CASE("f_r bends a valve that follows the note, and its own value is no bend") {
  Parameters p = find_preset("voice").value();
  p.tune = true;
  p.correct_pitch = false;
  const auto output = [&](double reed) {
    Instrument instrument;
    instrument.set(p);
    instrument.prepare(48000, 64);
    const Recording r = play(instrument, ramp(2000, 1.2, 48000), 48000, reed, 175);
    return pitch(part(r, r.bore_pressure, 0.6, 1.2), 48000, 150, 200);
  };
  CHECK(output(p.reed_frequency) == output(0));
  // Folds sound near their own frequency: well over half of a bend is heard.
  CHECK(output(1.05 * p.reed_frequency) > output(0) * 1.025);
  CHECK(output(0.95 * p.reed_frequency) < output(0) * 0.975);
}

/// What becomes of a cosine of that frequency and amplitude.
double radiated(const RadiationConstants& constants, double rate, double frequency,
                double amplitude, double length, int harmonic = 1) {
  RadiationPath path;
  path.prepare(192000);
  path.set(constants);
  std::vector<double> sound(static_cast<std::size_t>(rate));
  for (std::size_t i = 0; i < sound.size(); ++i)
    sound[i] = amplitude * std::cos(2 * kPi * frequency * static_cast<double>(i) / rate);
  for (std::size_t i = 0; i + 32 <= sound.size(); i += 32)
    path.run(sound.data() + i, 32, length);
  const std::span<const double> late(sound.data() + sound.size() / 2, sound.size() / 4);
  return std::abs(component(late, rate, harmonic * frequency));
}

TEST_CASE("a bell lets all power out above its cut-off and is a point source far below") {
  Parameters p;
  p.bell = 1500;
  p.bell_quality = 0.8;
  BoreDesign bore;
  bore.set(p, 192000);
  const RadiationConstants constants = RadiationConstants::from(p, bore, 192000);
  const double speed = bore.air().sound_speed;
  // One part in 30 for what is left of the passage between the limits at 10 Hz and 30 kHz.
  const double low = p.input_radius / 2 * (2 * kPi * 10 / speed) * p.input_radius;
  CHECK(radiated(constants, 192000, 10, 1, 0.5) == doctest::Approx(low).epsilon(0.03));
  CHECK(radiated(constants, 192000, 30000, 1, 0.5) ==
        doctest::Approx(p.input_radius / 2).epsilon(0.03));
}

TEST_CASE("a wave steepens as Fubini's solution says until it would break") {
  // Far above the cut-off the path is flat, so that the partials are the wave's own:
  // B_n = 2/(n sigma) J_n(n sigma), sigma = lead omega amplitude.
  Parameters p;
  p.bell = 100;
  p.brassiness = 5;
  BoreDesign bore;
  bore.set(p, 192000);
  const RadiationConstants constants = RadiationConstants::from(p, bore, 192000);
  const double frequency = 1000, length = 1.2;
  for (const double sigma : {0.2, 0.5}) {
    const double amplitude = sigma * 192000 / (constants.lead * length * 2 * kPi * frequency);
    const double first = radiated(constants, 192000, frequency, amplitude, length);
    for (int n = 2; n <= 3; ++n) {
      const double found = radiated(constants, 192000, frequency, amplitude, length, n) / first;
      const double fubini = std::cyl_bessel_j(n, n * sigma) / n / std::cyl_bessel_j(1, sigma);
      CAPTURE(sigma);
      CAPTURE(n);
      // Two passes of the implicit equation are right to sigma^3.
      CHECK(found == doctest::Approx(fubini).epsilon(0.01 + sigma * sigma * sigma));
    }
  }
}

TEST_CASE("steepening never makes a wave larger than it was") {
  Parameters p;
  p.bell = 1;
  p.brassiness = 100;
  BoreDesign bore;
  bore.set(p, 48000);
  const RadiationConstants constants = RadiationConstants::from(p, bore, 48000);
  RadiationPath path;
  path.prepare(192000);
  path.set(constants);
  double highest = 0;
  for (int i = 0; i < 48000; i += 32) {
    double sound[32];
    for (int k = 0; k < 32; ++k)
      sound[k] = 20e3 * std::sin(0.05 * (i + k));
    path.run(sound, 32, 20);
    for (const double s : sound)
      highest = std::max(highest, std::abs(s));
  }
  // Jumps at the interpolation's edges overshoot a little; the high-pass passes a jump twice.
  CHECK(highest < 2.5 * 20e3 * p.input_radius / 2);
}

TEST_CASE("presets radiate at an even level, below the soft clip at a moderate pressure") {
  const Tune tunes[] = {{"clarinet", 2000, {262}}, {"sax", 2000, {233}},
                        {"oboe", 2000, {440}},     {"trumpet", 3000, {294}},
                        {"trombone", 2200, {147}}, {"voice", 1500, {147}},
                        {"syrinx", 600, {1047}}};
  for (const Tune& tune : tunes) {
    Parameters p = find_preset(tune.preset).value();
    p.tune = true;
    Instrument instrument;
    instrument.set(p);
    instrument.prepare(48000, 64);
    const Recording r =
        play(instrument, ramp(tune.pressure, 1.2, 48000), 48000, 0, tune.notes.front());
    const auto output = part(r, r.sound, 0.7, 1.2);
    CAPTURE(std::string(tune.preset));
    CHECK(rms(output) > 0.03);
    CHECK(rms(output) < 0.25);
    for (const double s : output)
      REQUIRE(std::abs(s) < 0.6);
  }
}

} // namespace
} // namespace tactus::reed

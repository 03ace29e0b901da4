#include "core/reed/instrument/length_table.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/instrument/tuning.hpp"
#include "core/reed/player/player.hpp"
#include "core/reed/player/tuning_controller.hpp"
#include "tests/core/reed/render.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

/// A moving f_b with `tune 1`: vibrato, glides, slurs.
namespace tactus::reed {
namespace {

using namespace test;
constexpr double kPi = std::numbers::pi, kRate = 48000;
constexpr std::size_t kHop = 96; // samples between two readings of the pitch

struct Note {
  const char* preset;
  double pressure, frequency; // Pa, Hz
};

/// How far the pitch that sounds lies from the one meant at that moment, cents, every kHop samples,
/// read without delay: the bore pressure turned back by the phase meant, four periods of it under a
/// Hann window, whose zeros lie on all other harmonics.
std::vector<double> errors(const std::vector<double>& sound, const std::vector<double>& expected) {
  std::vector<std::complex<double>> turned(sound.size());
  double phase = 0;
  for (std::size_t i = 0; i < sound.size(); ++i) {
    turned[i] = sound[i] * std::polar(1.0, -phase);
    phase += 2 * kPi * expected[i] / kRate;
  }
  const auto smooth = [&](std::size_t at) {
    const auto half = static_cast<std::size_t>(2 * kRate / expected[at]);
    std::complex<double> sum = 0;
    for (std::size_t k = 0; k <= 2 * half; ++k)
      sum += turned[at + k - half] *
             (1 - std::cos(kPi * static_cast<double>(k + 1) / static_cast<double>(half + 1)));
    return sum;
  };
  std::vector<double> cents_error(sound.size() / kHop, 0.0);
  constexpr std::size_t kMargin = 1200, kApart = 48;
  for (std::size_t n = 0; n < cents_error.size(); ++n) {
    const std::size_t at = n * kHop;
    if (at < kMargin || at + kMargin >= sound.size())
      continue;
    const double turn = std::arg(smooth(at + kApart) * std::conj(smooth(at - kApart)));
    const double deviation = turn / (2.0 * kApart) * kRate / (2 * kPi) / expected[at];
    cents_error[n] = cents(std::max(0.01, 1 + deviation), 1);
  }
  return cents_error;
}

double largest(const std::vector<double>& errors, double from, double to) {
  double max_error = 0;
  for (auto n = static_cast<std::size_t>(from * kRate / kHop);
       n < static_cast<std::size_t>(to * kRate / kHop); ++n)
    max_error = std::max(max_error, std::abs(errors[n]));
  return max_error;
}

/// Plays f_b(t) at a pressure; how far it is off.
std::vector<double> played(const char* preset, double pressure, double seconds,
                           const std::function<double(double)>& frequency) {
  Parameters p = find_preset(preset).value();
  p.tune = true;
  Instrument instrument;
  instrument.set(p);
  instrument.prepare(kRate, 64);
  const std::vector<double> mouth = ramp(pressure, seconds, kRate);
  std::vector<double> bore(mouth.size());
  for (std::size_t i = 0; i < bore.size(); ++i)
    bore[i] = frequency(static_cast<double>(i) / kRate);
  const std::vector<double> reed(mouth.size(), 0.0);
  std::vector<double> sound(mouth.size()), theta(mouth.size()), inside(mouth.size()),
      flow(mouth.size());
  instrument.process<double>({mouth, reed, bore}, {sound, theta, inside, flow});
  CHECK(rms(std::span(inside).last(4800)) > 50);
  return errors(inside, bore);
}

const std::vector<Note> kNotes{
    {"clarinet", 2000, 227}, {"clarinet", 3000, 227}, {"sax", 2000, 227},
    {"sax", 2500, 286},      {"oboe", 2000, 340},     {"trumpet", 4000, 303},
    {"trumpet", 3000, 340},  {"trombone", 2000, 143}, {"voice", 2500, 146},
    {"syrinx", 600, 806},    {"syrinx", 800, 806}};

TEST_CASE("a vibrato of 50 cents at 6 Hz stays within 10 cents of the pitch meant" *
          doctest::skip(kSanitized)) {
  for (const Note& note : kNotes) {
    CAPTURE(std::string(note.preset));
    CAPTURE(note.pressure);
    const auto deviation = played(note.preset, note.pressure, 2, [&](double t) {
      return note.frequency *
             std::exp2(t < 0.8 ? 0 : 50 / 1200.0 * std::sin(2 * kPi * 6 * (t - 0.8)));
    });
    CHECK(largest(deviation, 1, 1.9) < 10);
  }
}

TEST_CASE("a vibrato of 2 cents from a note's start does not detune it" *
          doctest::skip(kSanitized)) {
  for (const Note& note : kNotes) {
    CAPTURE(std::string(note.preset));
    CAPTURE(note.pressure);
    const auto deviation = played(note.preset, note.pressure, 1.5, [&](double t) {
      return note.frequency * std::exp2(2 / 1200.0 * std::sin(2 * kPi * 6 * t));
    });
    CHECK(largest(deviation, 0.7, 1.4) < 10);
  }
}

TEST_CASE("glides and slurs of an octave arrive in tune" * doctest::skip(kSanitized)) {
  for (const Note& note : kNotes)
    for (const double time : {0.0, 0.05, 0.5, 2.0})
      for (const bool up : {true, false}) {
        const double low = note.frequency / 1.3;
        const std::string preset = note.preset;
        CAPTURE(std::string(note.preset));
        CAPTURE(note.pressure);
        CAPTURE(time);
        CAPTURE(up);
        const auto deviation = played(note.preset, note.pressure, 1 + time + 0.5, [&](double t) {
          const double variant = t < 1 ? 0 : t >= 1 + time ? 1 : (t - 1) / time;
          return low * std::exp2(up ? variant : 1 - variant);
        });
        CHECK(largest(deviation, 1 + time + 0.15, 1 + time + 0.45) < 10);
        // Underway: where neither the reed nor lips change their register on the way.
        const bool one_register = preset == "clarinet" || preset == "oboe" || preset == "syrinx" ||
                                  preset == "trombone" || (preset == "trumpet" && up) ||
                                  (preset == "voice");
        if (time == 2 && one_register)
          CHECK(largest(deviation, 1.15, 1 + time) < 10);
      }
}

TEST_CASE("a glide whose end lies out of the ear's reach is not stuck there" *
          doctest::skip(kSanitized)) {
  // The syrinx needs some 200 cents more at one end than at the other.
  const double from = 440 * std::exp2(11 / 12.0), to = 440 * std::exp2(18 / 12.0);
  for (const double time : {0.1, 0.5}) {
    const auto deviation = played("syrinx", 800, 2, [&](double t) {
      return from * std::pow(to / from, std::clamp((t - 1) / time, 0.0, 1.0));
    });
    CHECK(largest(deviation, 1 + time + 0.15, 1.95) < 10);
  }
}

TEST_CASE("the ear hears no error in a sine that follows the pitch meant") {
  for (const double detuned : {0.0, 0.01}) {
    TuningController controller;
    controller.prepare(kRate);
    double phase = 0, mean_trim = 0;
    constexpr int kHearings = 1500; // 1 s
    for (int n = 0; n < kHearings; ++n) {
      const double f = 220 * std::exp2(50 / 1200.0 * std::sin(2 * kPi * 6 * n / 1500.0));
      controller.set_target(f);
      double pressure[TuningController::kPeriod];
      for (double& p : pressure) {
        phase += 2 * kPi * f * (1 + detuned) / kRate;
        p = 500 * std::sin(phase);
      }
      controller.track_pitch(pressure, TuningController::kPeriod);
      controller.update();
      if (detuned == 0)
        REQUIRE(std::abs(controller.trim()) < 1e-3); // 1.7 cents
      mean_trim += controller.trim() / kHearings;
    }
    // Open loop: nothing heard says that the trim has helped, so it goes on to its limit.
    if (detuned > 0)
      CHECK(mean_trim < -0.05);
  }
}

TEST_CASE("the ear settles without overshoot, for it knows what it has asked for already") {
  TuningController controller;
  controller.prepare(kRate);
  const double sharp = 0.05; // the instrument, by nearly a semitone
  double phase = 0, min_trim = 0;
  for (int n = 0; n < 1500; ++n) {
    controller.set_target(110);
    double pressure[TuningController::kPeriod];
    for (double& p : pressure) {
      phase += 2 * kPi * 110 * (1 + sharp + controller.trim()) / kRate;
      p = 500 * std::sin(phase);
    }
    controller.track_pitch(pressure, TuningController::kPeriod);
    controller.update();
    min_trim = std::min(min_trim, controller.trim());
  }
  CHECK(controller.trim() == doctest::Approx(-sharp).epsilon(0.01));
  CHECK(min_trim > -1.08 * sharp); // an integral controller without that goes 13 % beyond
}

TEST_CASE("what notes needed is remembered, and runs straight between them") {
  TuningController controller;
  controller.prepare(kRate);
  // An instrument that sounds sharp by so much at a pitch, until it is trimmed.
  const auto sharp = [](double f) { return 0.02 + 0.03 * std::log2(f / 220); };
  double phase = 0;
  const auto play_note = [&](double f, int blocks) {
    for (int n = 0; n < blocks; ++n) {
      controller.set_target(f);
      double pressure[TuningController::kPeriod];
      for (double& p : pressure) {
        phase += 2 * kPi * f * (1 + sharp(f) + controller.trim()) / kRate;
        p = 500 * std::sin(phase);
      }
      controller.track_pitch(pressure, TuningController::kPeriod);
      controller.update();
    }
  };
  for (const double f : {220.0, 330.0, 440.0}) {
    play_note(f, 1500);
    CHECK(controller.trim() == doctest::Approx(-sharp(f)).epsilon(0.01));
  }
  for (int n = 0; n <= 3000; ++n) // a glide down from 440 to 220 in 2 s
    play_note(220 * std::exp2(1 - n / 3000.0), 1);
  double before = 0;
  for (int n = 0; n <= 3000; ++n) {
    controller.set_target(220 * std::exp2(n / 3000.0));
    if (n > 0)
      REQUIRE(std::abs(controller.trim() - before) < 5e-4); // never a jump
    before = controller.trim();
    REQUIRE(std::abs(controller.trim() + sharp(220 * std::exp2(n / 3000.0))) < 3e-3);
  }
}

TEST_CASE("lengths between the steps of the table are those of the search") {
  for (const char* preset : {"clarinet", "oboe", "trumpet", "trombone"}) {
    const Parameters p = find_preset(preset).value();
    LengthTable table;
    table.set(p);
    for (const double f : {150.0, 151.7, 153.3, 233.0, 301.0, 447.0}) {
      CAPTURE(std::string(preset));
      CAPTURE(f);
      const double length = table.length(f, p.reed_frequency, true, standard_fingering(p, f));
      const double searched = tuned(p, f, p.reed_frequency).length;
      // As the pitch of a bore: a cent is one part in 1731 of the round trip.
      CHECK(round_trip_turns(p, f, length) ==
            doctest::Approx(round_trip_turns(p, f, searched)).epsilon(0.5 / 1731));
    }
  }
}

TEST_CASE("a slide stays on its mode while it glides, and a new note takes the nearest") {
  Parameters p = find_preset("trombone").value();
  p.highest_mode = 0;
  LengthTable table;
  table.set(p);
  double before = table.length(110, p.reed_frequency, true);
  const double start = before;
  for (int n = 1; n <= 1200; ++n) {
    const double length = table.length(110 * std::exp2(n / 1200.0), p.reed_frequency, false);
    REQUIRE(std::abs(std::log(length / before)) < 0.002); // a cent is 0.0006
    before = length;
  }
  CHECK(before < 0.6 * start);
  CHECK(std::abs(std::log(table.length(220, p.reed_frequency, true) / p.length)) < 0.3);
}

TEST_CASE("bores are turned into round trips and back") {
  for (const Preset& preset : presets())
    for (const double length : {0.05, 0.5, 2.5})
      CHECK(length_from_turns(preset.parameters, 200,
                              round_trip_turns(preset.parameters, 200, length)) ==
            doctest::Approx(length).epsilon(1e-5));
}

TEST_CASE("a gliding note has the same bits however the stream is cut") {
  Parameters p = find_preset("trumpet").value();
  p.tune = true;
  p.breath_reference = 3000;
  const std::vector<double> mouth = ramp(4000, 0.4, kRate, 0.2);
  std::vector<double> bore(mouth.size()), reed(mouth.size(), 0.0);
  for (std::size_t i = 0; i < bore.size(); ++i)
    bore[i] = 262 * std::exp2(0.1 * std::sin(0.001 * static_cast<double>(i)));
  std::vector<double> sound[2], theta(bore.size()), inside(bore.size()), flow(bore.size());
  for (int variant = 0; variant < 2; ++variant) {
    sound[variant].resize(bore.size());
    Instrument instrument;
    instrument.set(p);
    instrument.prepare(kRate, 64);
    for (std::size_t at = 0, n = 0; at < bore.size(); at += n) {
      n = std::min<std::size_t>(variant == 0 ? 64 : 1 + at * 7 % 83, bore.size() - at);
      const auto in = [&](const std::vector<double>& x) { return std::span(x).subspan(at, n); };
      const auto out = [&](std::vector<double>& x) { return std::span(x).subspan(at, n); };
      instrument.process<double>({in(mouth), in(reed), in(bore)},
                                 {out(sound[variant]), out(theta), out(inside), out(flow)});
    }
  }
  CHECK(sound[0] == sound[1]);
}

TEST_CASE("with both powers one half a reed behaves alike at every pressure") {
  // Theory: jet flow w x sqrt(2 dp/rho) and valve force k x_0 both grow as p; only the channel's
  // inertance and the swept flow do not, which are left out here.
  Parameters p = find_preset("clarinet").value();
  p.tune = true;
  p.correct_pitch = false;
  p.sweep = false;
  p.channel_length = 1e-7;
  p.breath_reference = 2000;
  p.breath_quality = 0;
  p.gain = 1e-3; // below the soft clip
  const auto heard = [&](double share, double opening, double tension) {
    Parameters q = p;
    q.breath_opening = opening;
    q.breath_tension = tension;
    Instrument instrument;
    instrument.set(q);
    instrument.prepare(kRate, 64);
    const Recording r = play(instrument, ramp(2000 * share, 0.8, kRate), kRate, 0, 175);
    const auto late = part(r, r.bore_pressure, 0.5, 0.8);
    const double f = pitch(late, kRate, 160, 190);
    return std::array{rms(late) / share, f, harmonic_db(late, kRate, f, 3),
                      rms(part(r, r.sound, 0.5, 0.8)) / share};
  };
  const auto reference = heard(1, 0.5, 0.5);
  CHECK(reference[0] > 1000);
  for (const double share : {0.2, 0.5, 2.0, 5.0}) {
    const auto scaled = heard(share, 0.5, 0.5);
    CAPTURE(share);
    CHECK(scaled[0] == doctest::Approx(reference[0]).epsilon(0.003));
    CHECK(cents(scaled[1], reference[1]) == doctest::Approx(0).epsilon(1).scale(0.5));
    CHECK(std::abs(scaled[2] - reference[2]) < 0.05);
    CHECK(scaled[3] == doctest::Approx(reference[3]).epsilon(0.003));
  }
  // With less than one together p/P_M grows: the reed that is soft near its threshold beats when
  // loud, and lips that follow not at all are silent at a fifth of the pressure.
  CHECK(heard(0.2, 0.0, 0.0)[0] < 0.01 * reference[0]);
}

TEST_CASE("lips follow the breath within bounds, and not without a reference or a note") {
  Parameters p = find_preset("trombone").value();
  p.tune = true;
  BoreDesign bore;
  bore.set(p, kRate);
  const auto held = [&](double pressure, const Parameters& given, double note) {
    Player player;
    player.prepare(kRate);
    player.set(given, bore);
    for (int n = 0; n < 3000; ++n)
      player.control(note, given.reed_frequency, pressure);
    return player.control(note, given.reed_frequency, pressure);
  };
  const Parameters lips = player_lips(p, 147).valve;
  p.breath_reference = 0;
  CHECK(held(500, p, 147).valve.rest_angle == lips.rest_angle);
  p.breath_reference = 2000;
  p.breath_opening = 0.5;
  p.breath_tension = 0.3;
  for (const double pressure : {0.0, 1.0, 500.0, 2000.0, 6000.0, 5e4}) {
    const double r = std::clamp(pressure / 2000, Player::kMinBreathRatio, Player::kMaxBreathRatio);
    const auto hold = held(pressure, p, 147);
    CAPTURE(pressure);
    CHECK(hold.valve.rest_angle == doctest::Approx(lips.rest_angle * std::sqrt(r)).epsilon(1e-3));
    CHECK(hold.valve.mass == doctest::Approx(lips.mass * std::pow(r, 0.3)).epsilon(1e-3));
  }
  CHECK(held(500, p, 0).valve.rest_angle == p.rest_angle);
  CHECK(held(-1, p, 147).valve.rest_angle == lips.rest_angle); // several reeds: none to follow
}

TEST_CASE("a note that sounds in another register is tongued anew, three times at most") {
  Parameters p = find_preset("trumpet").value();
  p.tune = true;
  p.tongue = 0;
  BoreDesign bore;
  bore.set(p, kRate);
  Player player;
  player.prepare(kRate);
  player.set(p, bore);
  double phase = 0, before = 4000;
  int closed_count = 0, reopened_count = 0;
  for (int n = -3000; n < 6000;
       ++n) { // 2 s without and 4 s with breath: the twelfth of what is meant
    const double blown = n < 0 ? 0 : 4000;
    player.control(233, p.reed_frequency, blown);
    std::array<double, TuningController::kPeriod> mouth;
    mouth.fill(blown);
    player.apply_tongue(mouth.data(), TuningController::kPeriod, 50e3);
    if (n > 0) {
      closed_count += mouth.back() <= 0 && before > 0;
      reopened_count += mouth.back() >= 4000 && before < 4000;
    }
    before = mouth.back();
    double pressure[TuningController::kPeriod];
    for (double& x : pressure) {
      phase += 2 * kPi * 3 * 233 / kRate;
      x = 1000 * std::sin(phase);
    }
    player.track_pitch(pressure, TuningController::kPeriod);
  }
  CHECK(closed_count ==
        Player::kMaxAttempts); // without a burst, the tongue stops the air all the same
  CHECK(reopened_count == Player::kMaxAttempts);
}

TEST_CASE("a note beyond the compass is refused once, and the last good one goes on") {
  Parameters p = find_preset("clarinet").value();
  p.tune = true;
  p.lowest_note = 147;
  p.highest_note = 466;
  BoreDesign bore;
  bore.set(p, kRate);
  Player player;
  player.prepare(kRate);
  player.set(p, bore);
  const double good = player.control(300, 2500, 0).length;
  CHECK(player.refusal().count == 0);
  for (int n = 0; n < 100; ++n)
    CHECK(player.control(600, 2500, 0).length == good);
  CHECK(player.refusal().count == 1);
  CHECK(player.refusal().note == 600);
  for (int n = 0; n < 300; ++n) // a glide farther on is still the same wish
    player.control(600 + n, 2500, 0);
  CHECK(player.refusal().count == 1);
  player.control(140, 2500, 0);
  CHECK(player.refusal().count == 2);
  CHECK(player.control(144, 2500, 0).length != good); // half a semitone to spare
  CHECK(player.refusal().count == 2);
  // Nothing good yet: the nearest.
  Player fresh;
  fresh.prepare(kRate);
  fresh.set(p, bore);
  const double nearest = fresh.control(50, 2500, 0).length;
  CHECK(nearest == doctest::Approx(player.control(147, 2500, 0).length).epsilon(1e-9));
  CHECK(fresh.refusal().count == 1);
  // A length, or no player: f_b is only a bore.
  p.tune = false;
  fresh.set(p, bore);
  fresh.control(50, 2500, 0);
  CHECK(fresh.refusal().count == 1);
}

TEST_CASE("tongue and steepening are those of the note played, refused or fingered ones too") {
  const double note = 440 * std::exp2(-7.0 / 12);
  const auto sound = [](double fingering, double begin, double end) {
    Parameters p = find_preset("trumpet").value();
    p.tune = true;
    p.fingering = fingering;
    Instrument instrument;
    instrument.set(p);
    instrument.prepare(kRate, 64);
    const std::vector<double> mouth = ramp(4000, 1, kRate);
    std::vector<double> both = play(instrument, mouth, kRate, 0, begin).sound;
    const std::vector<double> held(mouth.size(), 4000.0);
    const Recording after = play(instrument, held, kRate, 0, end);
    both.insert(both.end(), after.sound.begin(), after.sound.end());
    return both;
  };
  const std::vector<double> plain = sound(0, note, note);
  CHECK(rms(std::span(plain).last(24000)) > 0.005);
  const auto apart = [&plain](const std::vector<double>& other) {
    double max_error = 0;
    for (std::size_t i = 0; i < plain.size(); ++i)
      max_error = std::max(max_error, std::abs(other[i] - plain[i]));
    return max_error;
  };
  CHECK(apart(sound(0, note, 4000)) < 1e-6); // lips that are held anew are rounded anew
  CHECK(sound(62, 0, 0) == plain);
}

} // namespace
} // namespace tactus::reed

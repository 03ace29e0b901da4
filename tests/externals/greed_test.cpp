#include "core/reed/instrument/presets.hpp"
#include "externals/greed~/greed~.hpp"
#include "tests/externals/by_name.hpp"
#include "tests/externals/recording_host.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

/// [greed~] as a patch sees it: messages while it sounds.
namespace tactus {
namespace {

constexpr double kRate = 48000;

/// An object that plays, block by block.
class PlayedObject {
public:
  PlayedObject(const char* preset, bool tune, double pressure, double note)
      : pressure_(pressure), note_(note) {
    test::send(object, "preset", {preset}, host);
    set("tune", tune ? 1 : 0);
    object.prepare(kRate, 64);
  }
  void set(std::string_view parameter, double value) { test::set(object, parameter, value); }
  [[nodiscard]] double get(std::string_view parameter) const {
    return test::get(object, parameter);
  }
  void play(double seconds) {
    constexpr std::size_t kBlock = 64;
    std::vector<double> mouth(kBlock), reed(kBlock, 0.0), bore(kBlock, note_), out[4];
    for (auto& signal : out)
      signal.resize(kBlock);
    for (auto blocks = static_cast<int>(seconds * kRate / kBlock); blocks > 0; --blocks) {
      for (double& p : mouth)
        p = pressure_ * std::min(1.0, static_cast<double>(sample_++) / (0.02 * kRate));
      const double* in[] = {mouth.data(), reed.data(), bore.data()};
      double* outs[] = {out[0].data(), out[1].data(), out[2].data(), out[3].data()};
      object.process<double>({in, outs, kBlock});
      object.report(host);
      sound.insert(sound.end(), out[0].begin(), out[0].end());
    }
  }
  void play_note(double note, double seconds) {
    note_ = note;
    play(seconds);
  }
  /// Largest difference between neighbouring samples of the last so many seconds.
  [[nodiscard]] double step(double seconds) const {
    double most = 0;
    for (std::size_t i = sound.size() - static_cast<std::size_t>(seconds * kRate); i < sound.size();
         ++i)
      most = std::max(most, std::abs(sound[i] - sound[i - 1]));
    return most;
  }

  Greed object;
  test::RecordingHost host;
  std::vector<double> sound;

private:
  double pressure_, note_;
  std::size_t sample_ = 0;
};

struct Sounding {
  const char* preset;
  bool tune;
  double pressure, note;
};

/// Every stride-th parameter, at its limits and 30 % from its value.
void check_clicks(std::span<const Sounding> notes, std::size_t stride) {
  for (const Sounding& note : notes)
    for (std::size_t k = 0; k < Greed::declaration.parameters.size(); k += stride) {
      const Parameter& parameter = Greed::declaration.parameters[k];
      const double now = PlayedObject(note.preset, note.tune, 0, 0).get(parameter.name);
      for (const double value : {parameter.lowest, parameter.highest, 1.3 * now, 0.7 * now}) {
        if (value == now || value < parameter.lowest || value > parameter.highest ||
            (!parameter.choices.empty() && value != std::floor(value)))
          continue;
        // A reed or a channel of 10 cm, or lips for a breath of 50 kPa under 3 kPa, drive the model
        // far beyond any instrument.
        if ((parameter.name == "lambda" || parameter.name == "width" ||
             parameter.name == "lip_width" || parameter.name == "breath_ref") &&
            value == parameter.highest)
          continue;
        INFO(std::string(note.preset), note.tune ? " tuned, " : ", ", std::string(parameter.name),
             " ", value);
        PlayedObject playing(note.preset, note.tune, note.pressure, note.note);
        playing.play(0.8);
        const double before = playing.step(0.2);
        playing.set(parameter.name, value);
        playing.play(0.4);
        const double during = playing.step(0.4);
        playing.play(0.3);
        double largest = std::max(before, playing.step(0.2));
        if (during > 2 * largest) { // a note blown anew is heard from 0.15 s after its beginning
          PlayedObject alone(note.preset, note.tune, note.pressure, note.note);
          alone.set(parameter.name, value);
          alone.play(0.75);
          largest = std::max(largest, alone.step(0.6));
        }
        CHECK(during <= 2 * largest);
      }
    }
}

constexpr Sounding kNotes[] = {{"clarinet", false, 2200, 0},  {"clarinet", true, 2200, 233},
                               {"sax", true, 2200, 233},      {"trumpet", true, 3500, 233},
                               {"trombone", true, 3000, 147}, {"syrinx", true, 600, 900}};

TEST_CASE("no parameter clicks when it changes while greed~ sounds") {
  check_clicks(std::span(kNotes).subspan(3, 1), 5);
}

TEST_CASE("no parameter of any preset clicks when it changes while greed~ sounds" *
          doctest::test_suite("slow")) {
  check_clicks(kNotes, 1);
}

TEST_CASE("a preset that comes while another sounds does not click") {
  for (const char* next : {"sax", "trombone", "trumpet", "syrinx"}) {
    CAPTURE(std::string(next));
    PlayedObject playing("clarinet", true, 2200, 233), alone(next, true, 2200, 233);
    alone.play(1);
    playing.play(0.8);
    test::send(playing.object, "preset", {next}, playing.host);
    const double before = playing.step(0.2);
    playing.play(1);
    CHECK(playing.step(1) <= 2 * std::max(before, alone.step(0.95)));
    CHECK(playing.get("gain") == doctest::Approx(reed::find_preset(next)->gain));
  }
}

TEST_CASE("valves are pressed by a list, dumped, and refused with one sentence") {
  PlayedObject playing("trumpet", true, 1000, 233);
  Greed& object = playing.object;
  test::RecordingHost& host = playing.host;
  const auto press = [&](std::vector<Atom> valves) {
    host.errors.clear();
    test::send(object, "valves", std::span<const Atom>(valves), host);
    object.dump(host);
    return host.errors.size();
  };
  CHECK(press({1.0, 3.0}) == 1); // an open end has none
  CHECK(host.errors.front() == "valves: expected end trumpet, which has valves");
  CHECK(host.said("valves") == "valves auto");
  playing.set("end", static_cast<double>(reed::BoreEnd::kTrumpet));
  playing.play(0.1);
  CHECK(press({1.0, 3.0}) == 0);
  CHECK(host.said("valves") == "valves 1 3");
  CHECK(press({3.0, 2.0}) == 0);
  CHECK(host.said("valves") == "valves 2 3");
  for (const std::vector<Atom>& wrong :
       {std::vector<Atom>{4.0}, {0.0}, {1.5}, {1.0, 1.0}, {"one"}, {1.0, "auto"}, {std::nan("")}}) {
    CHECK(press(wrong) == 1);
    CHECK(host.errors.front().find("expected valves of 1, 2 and 3") != std::string::npos);
    CHECK(host.said("valves") == "valves 2 3");
  }
  CHECK(press({}) == 0);
  CHECK(host.said("valves") == "valves");
  CHECK(press({"auto"}) == 0);
  CHECK(host.said("valves") == "valves auto");
}

TEST_CASE("a parameter that takes the value it has changes no bit") {
  PlayedObject one("clarinet", false, 2200, 200), other("clarinet", false, 2200, 200);
  one.play(0.5);
  other.play(0.5);
  for (const Parameter& parameter : Greed::declaration.parameters)
    other.set(parameter.name, other.get(parameter.name));
  one.play(0.2);
  other.play(0.2);
  CHECK(one.sound == other.sound);
}

TEST_CASE("a gliding parameter ends where an instrument made with it is") {
  PlayedObject made("clarinet", false, 2200, 0), changed("clarinet", false, 2200, 0);
  made.set("radius_end", 0.009);
  changed.play(0.5);
  changed.set("radius_end", 0.009);
  changed.play(1.5);
  made.play(2);
  // The same steady sound, whatever the phase.
  CHECK(changed.step(0.3) == doctest::Approx(made.step(0.3)).epsilon(0.02));
}

TEST_CASE("a note out of range is told once, with the limits") {
  PlayedObject playing("clarinet", true, 2200, 233);
  const auto refusals = [&] {
    return std::count_if(playing.host.infos.begin(), playing.host.infos.end(),
                         [](const std::string& one) { return one.starts_with("range "); });
  };
  playing.play(0.1);
  CHECK(refusals() == 0);
  playing.play_note(1397, 0.2);
  CHECK(refusals() == 1);
  const double low = playing.get("lowest_note");
  const double high = playing.get("highest_note");
  CHECK(playing.host.said("range") == "range 1397 " + number_text(low) + " " + number_text(high));
  playing.play_note(262, 0.1);
  playing.play_note(82, 0.1);
  CHECK(refusals() == 2);
  playing.set("tune", 0);
  playing.play(0.1); // until the sound has faded
  playing.play_note(60, 0.1);
  CHECK(refusals() == 2);
}

} // namespace
} // namespace tactus

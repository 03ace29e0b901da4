#include "core/reed/instrument/change_fade.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/player/player.hpp"
#include "core/reed/player/tongue.hpp"
#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

/// How a player's tongue begins notes and stops them.
namespace tactus::reed {
namespace {

using namespace test;
constexpr double kRate = 48000;

/// What the tongue makes of a breath.
std::vector<double> apply_tongue(std::vector<double> breath, double burst, int articulated = -1,
                                 double stop = 0) {
  Tongue tongue;
  tongue.prepare(kRate);
  tongue.set_burst(burst);
  for (std::size_t n = 0; n < breath.size(); n += 32) {
    if (articulated >= 0 && static_cast<int>(n / 32) == articulated)
      tongue.articulate(stop);
    const std::size_t count = std::min<std::size_t>(32, breath.size() - n);
    std::array<double, 32> factor;
    if (tongue.factors(breath.data() + n, factor.data(), static_cast<int>(count)))
      for (std::size_t i = 0; i < count; ++i)
        breath[n + i] *= factor[i];
  }
  return breath;
}

TEST_CASE("the tongue holds a quick breath back, lets it go with a burst and then lets it be") {
  const std::vector<double> breath = ramp(2000, 0.5, kRate), output = apply_tongue(breath, 1);
  const auto at = [](double seconds) { return static_cast<std::size_t>(seconds * kRate); };
  for (std::size_t n = 0; n < at(0.01); ++n)
    REQUIRE(output[n] == 0); // at most 12 ms
  // 1.5 ms after the release the valve feels p_m (1 + exp(-1.5/25)).
  const std::size_t release = static_cast<std::size_t>(
      std::find_if(output.begin(), output.end(), [](double p) { return p > 0; }) - output.begin());
  CHECK(release <= at(0.0125));
  const std::size_t open = release + at(0.0016);
  CHECK(output[open] ==
        doctest::Approx(breath[open] * (1 + std::exp(-0.0016 / 0.025))).epsilon(0.005));
  CHECK(output[release + at(0.1)] == doctest::Approx(2000 * (1 + std::exp(-4.0))).epsilon(0.005));
  CHECK(output.back() == doctest::Approx(2000).epsilon(1e-6));
  CHECK(apply_tongue(breath, 0) == breath); // none
}

TEST_CASE("the tongue leaves a slow breath alone and stops one within a note when asked") {
  const std::vector<double> slow = ramp(2000, 2.2, kRate, 2.0), output = apply_tongue(slow, 1);
  for (std::size_t n = 480; n < slow.size(); ++n)
    REQUIRE(output[n] == slow[n]);
  const std::vector<double> breath = ramp(2000, 0.5, kRate), again = apply_tongue(breath, 1, 375);
  double min_pressure = 1e9;
  for (std::size_t n = 12000; n < 13000; ++n)
    min_pressure = std::min(min_pressure, again[n]);
  CHECK(min_pressure == 0);
  CHECK(again.back() == doctest::Approx(2000).epsilon(0.001));
}

TEST_CASE("what the tongue is asked for in silence stops no breath that comes later") {
  std::vector<double> breath(9600, 0.0);
  std::fill(breath.begin() + 4800, breath.end(), 2000.0);
  CHECK(apply_tongue(breath, 1, 75, 0.05) == apply_tongue(breath, 1)); // at the 2400th sample
  CHECK(apply_tongue(breath, 0, 75, 0.05) == breath);
}

TEST_CASE("a breath that has begun without a burst is not stopped by one that is set later") {
  Tongue tongue;
  tongue.prepare(kRate);
  std::array<double, 480> breath, factor;
  breath.fill(2000);
  CHECK_FALSE(tongue.factors(breath.data(), factor.data(), 0));
  if (tongue.factors(breath.data(), factor.data(), 480))
    CHECK(*std::min_element(factor.begin(), factor.end()) == 1);
  tongue.set_burst(1);
  CHECK_FALSE(tongue.factors(breath.data(), factor.data(), 480));
  // Asked to, it stops the breath even without a burst, as long as it is told, and lets it go.
  tongue.set_burst(0);
  tongue.articulate(0.05);
  int stopped = 0;
  for (int n = 0; n < 20; ++n)
    if (tongue.factors(breath.data(), factor.data(), 480))
      stopped += static_cast<int>(std::count(factor.begin(), factor.end(), 0.0));
  CHECK(stopped == doctest::Approx(0.051 * kRate).epsilon(0.03));
  CHECK_FALSE(tongue.factors(breath.data(), factor.data(), 480));
}

/// The highest pressure that the valve feels when a player whose lips are there blows a note.
double highest_pressure(const Parameters& p, double note, double pressure) {
  Player player = make_player(p);
  for (int i = 0; i < 600; ++i)
    player.control(note, p.reed_frequency, pressure);
  double highest = 0;
  for (int i = 0; i < 100; ++i) {
    std::array<double, 32> mouth;
    mouth.fill(pressure);
    player.control(note, p.reed_frequency, pressure);
    player.apply_tongue(mouth.data(), 32, 50e3);
    highest = std::max(highest, *std::max_element(mouth.begin(), mouth.end()));
  }
  return highest;
}

/// By how much the tongue raises it, taken back to the release, 1.5 ms before the valve is open.
double excess(Parameters p, double note, double pressure) {
  p.lowest_note = p.highest_note = 0;
  return (highest_pressure(p, note, pressure) / pressure - 1) / std::exp(-1.5 / 25);
}

TEST_CASE("the tongue pushes low notes and soft breath harder, and a loud one not at all") {
  Parameters p = with_player("clarinet");
  p.tongue = 0.3;
  p.breath_opening = 0.4;
  p.breath_tension = 0.3;
  const double reference = p.breath_reference;
  const auto close = [](double value) { return doctest::Approx(value).epsilon(0.02); };
  CHECK(excess(p, 220, reference) == close(0.3));
  CHECK(excess(p, 440, reference) == close(0.3 / std::pow(2, 1.5)));
  // P_M goes as r^0.7, p as r.
  CHECK(excess(p, 220, 0.5 * reference) == close((1 + 0.3 * std::sqrt(2)) * std::pow(2, 0.3) - 1));
  CHECK(excess(p, 220, 4 * reference) == close(0.02));
  Parameters lips = with_player("trumpet");
  lips.tongue = 0.8;
  lips.breath_reference = 0;
  CHECK(excess(lips, 440, 3000) == close(0.8 / std::sqrt(2)));
  CHECK(excess(lips, 110, 500) == close(0.8 * std::sqrt(2)));
}

TEST_CASE("a change without a way in between keeps the breath while the sound fades out") {
  ChangeFade fade;
  fade.prepare(1500);
  fade.begin();
  int periods = 0;
  for (double before = fade.gain(); !fade.step(); before = fade.gain()) {
    REQUIRE(++periods < 100);
    CHECK(fade.breath_gain() == 1); // a reed that is let go sends a pulse
    CHECK(fade.gain() < before);
  }
  CHECK(periods <= 1500 * ChangeFade::kFadeOutTime + 2);
  for (const bool restarted : {false, true}) {
    fade.changed();
    fade.begin_silence(restarted);
    int silent = 0, swelling = 0;
    for (int n = 0; n < 600 && fade.gain() < 1; ++n) {
      fade.step();
      silent += fade.gain() == 0;
      swelling += fade.breath_gain() < 1;
    }
    // The breath is full long before the sound comes back.
    CHECK(silent ==
          doctest::Approx(1500 * (restarted ? ChangeFade::kRestartTime : ChangeFade::kSettleTime))
              .epsilon(0.1));
    CHECK(swelling == (restarted ? static_cast<int>(1500 * ChangeFade::kFadeInTime) : 0));
    CHECK(fade.gain() == 1);
    fade.begin();
    while (!fade.step())
      REQUIRE(++periods < 1000);
  }
}

TEST_CASE("what only a player uses is no change without one, and with one cannot be interpolated") {
  Parameters plain, all;
  all.embouchure = 1;
  all.embouchure_slope = -1;
  all.breath_reference = 1000;
  all.lip_mass = all.lip_width = all.lip_opening = all.lip_quality = 3;
  all.aim = 200;
  all.tube = true;
  all.correct_pitch = false;
  CHECK(can_continue(plain, all));
  plain.tune = all.tune = true;
  CHECK_FALSE(can_continue(plain, all));
  const auto one_changed = [&](auto member) {
    Parameters one = plain;
    one.*member = all.*member;
    return !can_interpolate(plain, one);
  };
  for (const auto member :
       {&Parameters::embouchure, &Parameters::embouchure_slope, &Parameters::breath_reference,
        &Parameters::lip_mass, &Parameters::lip_width, &Parameters::lip_opening,
        &Parameters::lip_quality, &Parameters::aim})
    CHECK(one_changed(member));
  CHECK(one_changed(&Parameters::tube));
  CHECK(one_changed(&Parameters::correct_pitch));
}

TEST_CASE("a player's breath never exceeds the highest mouth pressure") {
  Parameters p = with_player("trumpet");
  p.tongue = 3;
  CHECK(highest_pressure(p, 233, 20e3) == 50e3); // 80 kPa without the bound
}

} // namespace
} // namespace tactus::reed

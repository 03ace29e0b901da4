// The force that comes with the gradient, and the maps that lead it.
#include "core/reed/instrument/presets.hpp"
#include "core/reed/playability/gradient.hpp"
#include "core/reed/playability/playability_map.hpp"
#include "tests/core/reed/playability/guides.hpp"
#include "tests/core/reed/reference_instruments.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace tactus::reed {
namespace {

constexpr double kRate = 48000;
constexpr std::size_t kHandPeriod = ReedGradient::kHandPeriod;
constexpr double kHandPeriod_s = static_cast<double>(kHandPeriod) / kRate;
constexpr double kForcePeriod_s = static_cast<double>(ReedGradient::kForcePeriod) / kRate;

ReedGradient trumpet(ReedGradient::Mode mode) {
  ReedGradient gradient;
  gradient.set(reference::trumpet());
  gradient.set_range({0, 8000, 80, 900});
  gradient.prepare(kRate);
  gradient.set_mode(mode);
  return gradient;
}

void stay(ReedGradient& gradient, double y, double z, double seconds) {
  std::vector<double> sound(kHandPeriod);
  for (double t = 0; t < seconds; t += kHandPeriod_s) {
    gradient.move(y, z, 0);
    gradient.process(sound);
  }
}

} // namespace

TEST_CASE("a hand that raises the pressure for 2 s makes a trumpet speak on its way") {
  // Above the threshold of fixed lips, at half the way, notes grow from the breath's noise.
  const auto speaks_at = [](double noise) {
    Parameters p = find_preset("trumpet").value();
    p.breath_noise = noise;
    ReedGradient gradient;
    gradient.set(p);
    gradient.set_range({0, 8000, 82.5, 907.5});
    gradient.prepare(kRate);
    std::vector<double> sound(kHandPeriod);
    for (double t = 0; t < 3; t += kHandPeriod_s) {
      gradient.move(0.6 * std::min(1.0, t / 2), 0.5, 0);
      gradient.process(sound);
      for (const double x : sound)
        if (std::abs(x) > 0.02)
          return t;
    }
    return 3.0;
  };
  CHECK(speaks_at(5e-4) < 2);
  CHECK(speaks_at(1e-7) > 2.2);
  ReedGradient gradient = trumpet(ReedGradient::Mode::kReed);
  Parameters p = find_preset("trumpet").value();
  p.breath_noise = 5e-4;
  gradient.set(p);
  std::vector<double> sound(kHandPeriod);
  for (double t = 0; t < 2; t += kHandPeriod_s) { // a step would ring for long
    gradient.move(0.15 * std::min(1.0, t / 0.3), 0.5, 0);
    gradient.process(sound);
  }
  double loudest = 0;
  for (int n = 0; n < 300; ++n) {
    gradient.move(0.15, 0.5, 0);
    gradient.process(sound);
    for (const double x : sound)
      loudest = std::max(loudest, std::abs(x));
  }
  CHECK(loudest < 3.2e-5); // -90 dB
}

TEST_CASE(
    "mode guide pulls out of silence with all of its ceiling, and lets go where a note plays") {
  for (const double ceiling : {0.5, 2.0}) {
    ReedGradient gradient = trumpet(ReedGradient::Mode::kGuide);
    gradient.set_ceiling(ceiling);
    stay(gradient, 0.05, 0.45, 0.5);
    CHECK(std::hypot(gradient.force().y, gradient.force().z) == 0); // no map yet
    const PlaneGuide guide = test::guide_of(gradient.plane());
    gradient.set_guide(&guide);
    stay(gradient, 0.05, 0.45, 0.5);
    CHECK(gradient.playability() < 1e-3);
    CHECK(gradient.force().y > 0.5 * ceiling); // towards more pressure
    CHECK(std::hypot(gradient.force().y, gradient.force().z) ==
          doctest::Approx(ceiling).epsilon(0.02));
    // The list is the direction of the force.
    const Gradient slope = gradient.gradient();
    CHECK(std::hypot(slope.y, slope.z) == doctest::Approx(1).epsilon(0.02));
    CHECK(gradient.force().y == doctest::Approx(ceiling * slope.y).epsilon(1e-6));
    CHECK(gradient.force().z == doctest::Approx(ceiling * slope.z).epsilon(1e-6));
    // The place deepest inside the wall of 0.05.
    double y = 0, z = 0;
    for (double at_y = 0; at_y < 1; at_y += 0.02)
      for (double at_z = 0; at_z < 1; at_z += 0.02)
        if (guide.distance_field.distance(at_y, at_z) < guide.distance_field.distance(y, z)) {
          y = at_y;
          z = at_z;
        }
    REQUIRE(guide.distance_field.distance(y, z) < -0.06);
    stay(gradient, y, z, 0.8);
    CHECK(gradient.playability() > 0.5);
    CHECK(std::hypot(gradient.force().y, gradient.force().z) == 0);
  }
}

TEST_CASE("modes reed and growth push with the patch's law of their slope") {
  for (const auto mode : {ReedGradient::Mode::kReed, ReedGradient::Mode::kGrowth}) {
    ReedGradient gradient = trumpet(mode);
    gradient.set_ceiling(1);
    gradient.set_force_gain(0.3);
    const PlaneGuide guide = test::guide_of(gradient.plane());
    gradient.set_guide(&guide);
    ForceSmoother smoother; // 30 ms, 20 N/s
    std::vector<double> sound(kHandPeriod);
    PlaneForce expected;
    for (int n = 0; n < 1500; ++n) {
      gradient.move(0.5, 0.42, 0);
      if (n % 2 == 1)
        expected = smoother.advance(gradient_force(gradient.gradient(), 0.3, 1), kForcePeriod_s);
      REQUIRE(gradient.force().y == expected.y);
      REQUIRE(gradient.force().z == expected.z);
      gradient.process(sound);
    }
    CHECK(std::abs(expected.y) > 0.01);
  }
}

TEST_CASE("the force has the same bits however the stream is cut into blocks") {
  const auto forces = [](std::size_t block) {
    ReedGradient gradient = trumpet(ReedGradient::Mode::kGuide);
    const PlaneGuide guide = test::guide_of(gradient.plane());
    gradient.set_guide(&guide);
    std::vector<double> sound(block), seen;
    std::size_t sample = 0;
    for (std::size_t n = 0; n < 24000;) {
      if (gradient.samples_until_hand() == 0) {
        seen.push_back(gradient.force().y);
        seen.push_back(gradient.force().z);
        const double t = static_cast<double>(n) / kRate;
        gradient.move(0.4 + 0.4 * std::sin(9 * t), 0.5 + 0.3 * std::sin(7 * t), 0);
      }
      const std::size_t left =
          gradient.samples_until_hand() > 0 ? gradient.samples_until_hand() : kHandPeriod;
      const std::size_t count = std::min({left, block - sample, 24000 - n});
      gradient.process(std::span(sound).first(count));
      n += count;
      sample = (sample + count) % block;
    }
    return seen;
  };
  const std::vector<double> whole = forces(4096);
  CHECK(forces(1) == whole);
  CHECK(forces(64) == whole);
  CHECK(forces(100) == whole);
}

TEST_CASE("another mode goes on from the force that was, and letting go ends it") {
  ReedGradient gradient = trumpet(ReedGradient::Mode::kGuide);
  const PlaneGuide guide = test::guide_of(gradient.plane());
  gradient.set_guide(&guide);
  stay(gradient, 0.05, 0.45, 0.5);
  const PlaneForce before = gradient.force();
  REQUIRE(std::hypot(before.y, before.z) > 1.9);
  gradient.set_mode(ReedGradient::Mode::kReed);
  stay(gradient, 0.05, 0.45, kForcePeriod_s);
  CHECK(std::abs(gradient.force().y - before.y) <= 20 * kForcePeriod_s * 1.001); // 20 N/s
  CHECK(std::abs(gradient.force().z - before.z) <= 20 * kForcePeriod_s * 1.001);
  gradient.release_force();
  CHECK(std::hypot(gradient.force().y, gradient.force().z) == 0);
}

TEST_CASE("a hand that is nowhere gets a finite force in every mode") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const double strange[] = {kNan, kInf, -kInf, 1e300, -5, 0.5, 0, 3};
  for (const auto mode :
       {ReedGradient::Mode::kReed, ReedGradient::Mode::kGrowth, ReedGradient::Mode::kGuide}) {
    ReedGradient gradient = trumpet(mode);
    const PlaneGuide guide = test::guide_of(gradient.plane());
    gradient.set_guide(&guide);
    std::vector<double> sound(kHandPeriod);
    for (int n = 0; n < 1000; ++n) {
      gradient.move(strange[n % 8], strange[(n / 8) % 8], strange[(n / 64) % 8]);
      gradient.process(sound);
      REQUIRE(std::hypot(gradient.force().y, gradient.force().z) <= 2 * std::sqrt(2.0));
    }
    // And afterwards it is as if nothing had been.
    stay(gradient, 0.05, 0.45, 1);
    if (mode == ReedGradient::Mode::kGuide)
      CHECK(gradient.force().y > 1);
  }
}

TEST_CASE("theory maps the lips that the player of a tuned note takes" *
          doctest::skip(kSanitized)) {
  // A note for each preset that is not its own length's: the lips go with it.
  for (const auto& choice : {std::pair{"trumpet", 311.0}, {"trombone", 92.0}}) {
    const char* const name = choice.first;
    const double note = choice.second;
    CAPTURE(name);
    Parameters p = find_preset(name).value();
    p.tune = true;
    p.correct_pitch = false; // which trims what theory leaves
    PlayabilityMapSettings settings;
    settings.parameters = p;
    settings.bore_frequency = note;
    settings.range = {0, 8000, 0.25 * p.reed_frequency, 2.75 * p.reed_frequency};
    constexpr std::size_t kNodes = 21;
    PlayabilityMap played;
    played.begin(settings, kNodes, kNodes);
    for (std::size_t n = 0; n < played.size();)
      n = played.advance(n);

    const auto agreement = [&](const PlayingSetup& playing) {
      GrowthMap theory;
      theory.prepare(kNodes, kNodes);
      theory.begin(playing, settings.range);
      (void)theory.advance(kNodes * kNodes);
      int same = 0, all = 0;
      for (std::size_t k = 0; k < kNodes; ++k)
        for (std::size_t i = 0; i < kNodes; ++i) {
          const double g = theory.growth().node(i, k);
          if (std::abs(g) < 5) // has not spoken, or died, within the half second it is given
            continue;
          ++all;
          same += (theory.height().node(i, k) > 0) == (played.field().node(i, k) > 0.1) ? 1 : 0;
        }
      return static_cast<double>(same) / all;
    };
    const double held = agreement(embouchure_for(p, note, played.length()));
    const double given = agreement({p, played.length()});
    CAPTURE(held);
    CAPTURE(given);
    CHECK(held > 0.95);
    CHECK(held > given + 0.05);
  }
}

TEST_CASE("the player's lips are tuned()'s, and the valve as given without a note to play") {
  for (const Preset& preset : presets()) {
    Parameters p = preset.parameters;
    CAPTURE(preset.name);
    for (const double note : {0.0, 200.0}) {
      const PlayingSetup plain = embouchure_for(p, note, 0.7);
      CHECK(plain.length == 0.7);
      CHECK(plain.reed_scale == 1);
      CHECK(plain.valve.mass == p.mass);
    }
    p.tune = true;
    CHECK(embouchure_for(p, 0, 0.7).valve.mass == p.mass);
    const PlayingSetup held = embouchure_for(p, 200, 0.7), chosen = tuned(p, 200, p.reed_frequency);
    CHECK(held.valve.mass == chosen.valve.mass);
    CHECK(held.valve.width == chosen.valve.width);
    CHECK(held.reed_scale == chosen.reed_scale);
    p.length_override = 0.5;
    CHECK(embouchure_for(p, 200, 0.7).valve.mass == p.mass);
  }
}

} // namespace tactus::reed

#include "tests/approx.hpp"
#include "tests/core/footstep/plain_ground.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

// What holds for all of a ground: the weight on it, places, the air, silence.

using namespace tactus::footstep;
using namespace tactus::test;
namespace test = tactus::test;

TEST_CASE("a heavier body has more striking mass and energy, and its particles last longer") {
  const auto of = [](const std::string& text, double weight, const SoleState& sole) {
    const auto ground = ground_of(text);
    ground->set_weight(weight);
    return vibration(*ground, sole, 9600);
  };
  // Landings of one mode: half the weight is half the mass.
  CHECK(factor(of(board("heel 0.08\n"), 350, heel_at(0.5)),
               of(board("heel 0.04\n"), 700, heel_at(0.5))) == test::approx(1).epsilon(1e-9));
  SoleState ball;
  ball.ball_landing = 0.4;
  CHECK(factor(of(board("ball 1\nball_mass 0.06\n"), 1400, ball),
               of(board("ball 1\nball_mass 0.12\n"), 700, ball)) == test::approx(1).epsilon(1e-9));
  // Particles: what sounds is a fixed part of the energy, its power; times with the weight's root.
  const auto heavy = of(rustle("heel 1\nball 1\n"), 2800, heel_at(0.5));
  const auto equal = of(rustle("decay 0.1\nheel 2\nball 1\n"), 700, heel_at(0.5));
  CHECK(factor(heavy, equal) == test::approx(1).epsilon(1e-6));
  // Nobody weighs more than 14 kN; up to there twice the weight is twice the mass.
  CHECK(factor(of(board("heel 0.01\n"), 14000, heel_at(0.5)),
               of(board("heel 0.02\n"), 7000, heel_at(0.5))) == test::approx(1).epsilon(1e-9));
  CHECK(factor(of(board("heel 0.01\n"), 1e9, heel_at(0.5)),
               of(board("heel 0.01\n"), 14000, heel_at(0.5))) == test::approx(1).epsilon(1e-9));
  CHECK(peak_amplitude(of(board(""), 0, heel_at(0.5))) == 0);
  CHECK(peak_amplitude(of(rustle("heel 1\n"), 0, heel_at(0.5))) == 0);
}

TEST_CASE("the sound falls below the radiation frequency of the floor") {
  for (const double radiation : {40.0, 400.0, 4000.0}) {
    CAPTURE(radiation);
    Recipe recipe = recipe_of(board(""));
    recipe.radiation_hz = radiation;
    const auto ground = std::make_unique<Ground>();
    ground->prepare(96000);
    ground->set(recipe, 0.4);
    double pressure_pa = 0, motion = 0;
    for (int n = 0; n < 19200; ++n) {
      const Ground::Sound sound = ground->next(n == 0 ? heel_at(0.5) : SoleState{});
      if (n < 4800)
        continue;
      pressure_pa += sound.pressure_pa * sound.pressure_pa;
      motion += both(sound) * both(sound);
    }
    // A first-order high-pass, 400 Hz through it.
    const double x = 400 / radiation;
    CHECK(std::sqrt(pressure_pa / motion) == test::approx(x / std::sqrt(1 + x * x)).epsilon(0.04));
  }
}

namespace {

void check_scatter(std::uint64_t steps, double tolerance) {
  // Logarithms are normal, cut at 2.5 deviations: 0.984 of the deviation is left.
  std::vector<double> frequencies, decays, levels, tunings;
  for (std::uint64_t seed = 1; seed <= steps; ++seed) {
    const auto tone = [&](const std::string& more) {
      return tone_of(
          vibration(*ground_of(board("t60 0.3\n" + more), 22050, seed), heel_at(0.5), 4000), 22050,
          0.02);
    };
    frequencies.push_back(std::log(tone("vary_frequency 0.1\n").frequency_hz));
    decays.push_back(std::log(tone("vary_decay 0.2\n").t60_s));
    tunings.push_back(std::log(tone("detune 0.1\n").frequency_hz));
    levels.push_back(std::log(peak_amplitude(
        vibration(*ground_of(board("vary_level 0.3\n"), 48000, seed), heel_at(0.5), 960))));
  }
  CHECK(scatter(frequencies) == test::approx(0.0984).epsilon(tolerance));
  CHECK(scatter(decays) == test::approx(0.197).epsilon(tolerance));
  CHECK(scatter(tunings) == test::approx(0.1).epsilon(tolerance));
  CHECK(scatter(levels) == test::approx(0.295).epsilon(tolerance));
}

} // namespace

// A scatter of n values is known to 1/sqrt(2 n): three of these.
TEST_CASE("steps differ by the recipe's scatter of frequency, decay and strength") {
  check_scatter(50, 0.3);
}
TEST_CASE("steps differ by the recipe's scatter within 18 %" * doctest::test_suite("slow")) {
  check_scatter(150, 0.18);
}

TEST_CASE("the variation of a whole recipe is one factor for all its sections") {
  // Of one seed the first step draws one factor, whatever sections come after.
  const auto frequency_hz = [](const std::string& section, std::uint64_t seed) {
    const auto ground = ground_of("radiation 1\nfelt 1\nvary_frequency 0.3\n" + section +
                                      "modes 1\ndetune 0\nt60 2\nvary_frequency 0\nvary_decay 0\n",
                                  48000, seed);
    std::vector<double> motion;
    for (int n = 0; n < 30000; ++n) {
      SoleState sole = heel_at(n == 1 ? 0.5 : 0);
      // Boards are set ringing by a slip that lasts 50 ms.
      sole.heel_n = sole.ball_n = n > 0 && n < 2400 ? 350 : 0;
      sole.ball_slope = n > 0 && n < 2400 ? 70000 : 0;
      motion.push_back(both(ground->next(sole)));
    }
    return tone_of(motion, 48000, 0.125).frequency_hz;
  };
  double lowest = 1e9, highest = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const double solid = frequency_hz("[solid]\nfrequency 600\nball 0\n", seed),
                 boards = frequency_hz("[friction]\nfrequency 900\npressed 0\n", seed);
    CHECK(boards / solid == test::approx(1.5).epsilon(0.02));
    lowest = std::min(lowest, solid);
    highest = std::max(highest, solid);
  }
  CHECK(highest > 1.5 * lowest);
}

TEST_CASE("each step has new contact points, and its later landings keep them") {
  const auto ground = ground_of(board("vary_frequency 0.2\nball 1\n"));
  const auto tone = [&](bool heel, double load) {
    std::vector<double> motion;
    for (int n = 0; n < 24000; ++n) {
      SoleState sole;
      (heel ? sole.heel_landing : sole.ball_landing) = n == 0 ? 0.5 : 0;
      sole.heel_n = load;
      motion.push_back(both(ground->next(sole)));
    }
    return tone_of(motion, 48000, 0.02).frequency_hz;
  };
  const double first = tone(true, 700); // the foot stays
  CHECK(tone(false, 0) == test::approx(first).epsilon(1e-3));
  const double second = tone(true, 700); // and lifts before
  CHECK(std::abs(std::log(second / first)) > 0.01);
  const double third = tone(true, 0); // lands once more without having left
  CHECK(std::abs(std::log(third / second)) > 0.01);
  const double ball_first = tone(false, 700);
  CHECK(std::abs(std::log(ball_first / third)) > 0.01);
  CHECK(tone(true, 0) == test::approx(ball_first).epsilon(1e-3));
}

TEST_CASE("a ground is silent before the first step, while nothing sounds, and after a reset") {
  for (const char* section : {"[solid]\nt60 0.05\n", "[friction]\nt60 0.05\n", "[grains]\nload 1\n",
                              "[bubbles]\nload 1\n", "[rustle]\nload 1\n"}) {
    CAPTURE(section);
    const auto ground = ground_of(section);
    const auto run_foot = [&](int samples) {
      double peak = 0;
      for (int n = 0; n < samples; ++n) {
        SoleState sole = heel_at(n == 0 ? 1 : 0);
        sole.heel_n = sole.ball_n = 350;
        sole.ball_slope = 7000;
        peak = std::max(peak, std::abs(both(ground->next(sole))));
        CHECK_FALSE(ground->silent());
      }
      return peak;
    };
    CHECK(ground->silent());
    CHECK(both(ground->next({})) == 0);
    CHECK(ground->silent());
    CHECK(run_foot(2000) > 0);
    CHECK_FALSE(ground->silent());
    int samples = 0;
    for (; samples < 48000 * 20 && !ground->silent(); ++samples)
      ground->next({});
    CHECK(ground->silent());
    CHECK(samples > 20);
    CHECK(ground->next({}).pressure_pa == 0);
    CHECK(run_foot(2000) > 0);
    ground->reset();
    CHECK(ground->silent());
    CHECK(both(ground->next({})) == 0);
  }
}

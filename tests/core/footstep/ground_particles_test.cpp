#include "core/contact/excited_body.hpp"
#include "core/footstep/shoe.hpp"
#include "tests/approx.hpp"
#include "tests/core/footstep/plain_ground.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

// What sets the particles of a ground free, and how many.

using namespace tactus::footstep;
using namespace tactus::test;
namespace contact = tactus::contact;
namespace test = tactus::test;

TEST_CASE("a soft sole reduces the level of particles on a floor like the force of a landing") {
  const std::string floor = "[solid]\nlevel 0\nexponent 1.6\nstiffness 1e9\ndissipation 0\n";
  const auto loud = [](const std::string& text, double shoe) {
    return vibration(*ground_of(text, 48000, 1, shoe), heel_at(0.5));
  };
  const std::string on_floor = rustle("heel 1\nball 1\n") + floor, alone = rustle("heel 1\n");
  // Greatest force of an elastic landing of energy W: k^(1/(a+1)) ((a+1) W)^(a/(a+1)).
  const auto force = [](double shoe) {
    const contact::ImpactLaw law = in_series({1e9, 1.6, 0}, sole_law(shoe, 1.6));
    return law.force(law.deepest(0.01), 0);
  };
  const auto usual = loud(on_floor, 0.4);
  CHECK(factor(usual, loud(alone, 0.4)) == test::approx(1).epsilon(1e-9));
  for (const double shoe : {0.0, 0.7, 1.0}) {
    CHECK(factor(loud(on_floor, shoe), usual) ==
          test::approx(force(shoe) / force(0.4)).epsilon(1e-3));
    CHECK(factor(loud(alone, shoe), loud(alone, 0.4)) == test::approx(1).epsilon(1e-9));
  }
}

TEST_CASE("a landing stirs particles as fast as it is, up to 4 m/s, at 0.5 m/s as said: power with "
          "its square") {
  const auto of = [](const std::string& text, const SoleState& sole) {
    return vibration(*ground_of(rustle(text)), sole);
  };
  const auto usual = of("heel 1\n", heel_at(0.5));
  CHECK(factor(of("heel 3\n", heel_at(0.5)), usual) == test::approx(3));
  CHECK(factor(of("heel 1\n", heel_at(1)), usual) == test::approx(2));
  CHECK(factor(of("heel 1\n", heel_at(3.9)), usual) == test::approx(7.8));
  CHECK(factor(of("heel 1\n", heel_at(50)), usual) == test::approx(8));
  SoleState sole;
  sole.ball_landing = 0.25;
  CHECK(factor(of("ball 2\n", sole), usual) == test::approx(1));
  CHECK(peak_amplitude(of("heel 1\n", sole)) == 0);
  CHECK(peak_amplitude(of("ball 1\n", heel_at(0.5))) == 0);
  CHECK(factor(of("heel 1\nlevel 5\n", heel_at(0.5)), usual) == test::approx(5));
  // The energy arrives in the attack: its rise passes 1 - 1/e there.
  const auto late = of("attack 0.02\ndecay 10\nheel 1\n", heel_at(0.5));
  const auto soon = of("attack 1e-4\ndecay 10\nheel 1\n", heel_at(0.5));
  for (const int n : {480, 960, 1920})
    CHECK(late[static_cast<std::size_t>(n)] / soon[static_cast<std::size_t>(n)] ==
          test::approx(1 - std::exp(-(n + 1) / 960.)).epsilon(0.01));
}

TEST_CASE("rising load gives energy by `load`, falling load by `release`, per 700 N") {
  const auto power = [](const std::string& text, double slope, bool ball = false) {
    const auto ground = ground_of(rustle(text));
    std::vector<double> motion;
    for (int n = 0; n < 2400; ++n) {
      SoleState sole;
      (ball ? sole.ball_slope : sole.heel_slope) = slope;
      sole.heel_n = 100;
      motion.push_back(both(ground->next(sole)));
    }
    return motion;
  };
  const auto usual = power("load 1\n", 7000);
  CHECK(factor(power("load 2\n", 7000), usual) == test::approx(2).epsilon(1e-6));
  CHECK(factor(power("load 1\n", 3500), usual) == test::approx(0.5).epsilon(1e-6));
  CHECK(factor(power("load 1\n", 7000, true), usual) == test::approx(1).epsilon(1e-6));
  CHECK(factor(power("release 3\n", -7000), usual) == test::approx(3).epsilon(1e-6));
  CHECK(peak_amplitude(power("load 1\n", -7000)) == 0);
  CHECK(peak_amplitude(power("release 1\n", 7000)) == 0);
  // 200 times 700 N a second are the steepest.
  CHECK(factor(power("load 1\n", 190 * 700), usual) == test::approx(19).epsilon(1e-6));
  CHECK(factor(power("load 1\n", 500 * 700), usual) == test::approx(20).epsilon(1e-6));
  CHECK(factor(power("release 1\n", -500 * 700), usual) == test::approx(20).epsilon(1e-6));
}

TEST_CASE("a sliding sole drives particles by force times distance, and rubs the floor") {
  const auto slid = [](const std::string& text, double force, double speed, bool ball) {
    const auto ground = ground_of(text);
    std::vector<double> motion;
    for (int n = 0; n < 4800; ++n) {
      SoleState sole;
      (ball ? sole.ball_n : sole.heel_n) = force;
      (ball ? sole.ball_slip : sole.heel_slip) = speed;
      const Ground::Sound sound = ground->next(sole);
      REQUIRE((ball ? sound.heel_vibration : sound.ball_vibration) == 0);
      motion.push_back(both(sound));
    }
    return motion;
  };
  const auto usual = slid(rustle("slide 5\n"), 70, 0.5, false);
  CHECK(factor(slid(rustle("slide 10\n"), 70, 0.5, false), usual) == test::approx(2).epsilon(1e-6));
  CHECK(factor(slid(rustle("slide 5\n"), 140, 0.5, true), usual) == test::approx(2).epsilon(1e-6));
  CHECK(factor(slid(rustle("slide 5\n"), 70, -1, false), usual) == test::approx(2).epsilon(1e-6));
  // 0.2 energies (5 a metre, 0.1 of 700 N, 0.5 m/s) a second: as a load of 0.25 a second brings.
  const auto ground = ground_of(rustle("load 1\n"));
  std::vector<double> loaded;
  for (int n = 0; n < 4800; ++n) {
    SoleState sole;
    sole.heel_n = 70;
    sole.heel_slope = 0.25 * 700;
    loaded.push_back(both(ground->next(sole)));
  }
  CHECK(factor(usual, loaded) == test::approx(1).epsilon(1e-6));
  for (const bool ball : {false, true}) {
    CHECK(peak_amplitude(slid(board("roughness 1\n"), 70, 0.5, ball)) > 1e-4);
    CHECK(peak_amplitude(slid(board("roughness 1\n"), 70, 0, ball)) == 0);
  }
}

TEST_CASE("particles driven by one part of the sole vibrate only that part, in every step") {
  // Also where decay times differ from step to step and grow with the weight.
  for (const double weight : {350.0, 700.0, 1400.0})
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
      for (const bool ball : {false, true}) {
        const auto ground = ground_of("radiation 1\nfelt 1\nvary_decay 0.3\n[rustle]\nheel 1\n"
                                      "ball 1\nload 0\nrelease 0\ndecay 0.05\nvary_decay 0.5\n",
                                      48000, seed);
        ground->set_weight(weight);
        double here = 0, elsewhere = 0;
        for (int n = 0; n < 9600; ++n) {
          SoleState sole;
          (ball ? sole.ball_landing : sole.heel_landing) = n == 0 ? 0.5 : 0;
          const Ground::Sound sound = ground->next(sole);
          here = std::max(here, std::abs(ball ? sound.ball_vibration : sound.heel_vibration));
          elsewhere =
              std::max(elsewhere, std::abs(ball ? sound.heel_vibration : sound.ball_vibration));
        }
        CHECK(here > 0);
        CHECK(elsewhere < 1e-9 * here);
      }
}

#include "tests/approx.hpp"
#include "tests/core/footstep/plain_ground.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

// CreakingBoards: boards that stick and slip under a load that moves.

using namespace tactus::footstep;
using namespace tactus::test;
namespace test = tactus::test;

TEST_CASE("boards that rub keep their frequency and decay at any sample rate") {
  for (const double rate : {22050.0, 48000.0, 96000.0}) {
    CAPTURE(rate);
    const auto ground =
        ground_of("radiation 1\nfelt 1\n[friction]\nmodes 1\nfrequency 900\n"
                  "detune 0\nt60 0.2\npressed 0\njoint_t60 0.005\nvary_frequency 0\n"
                  "vary_decay 0\nvary_level 0\n",
                  rate);
    std::vector<double> sound;
    for (int n = 0; n < 0.3 * rate; ++n) { // 50 ms of load that moves, then the foot lifts
      SoleState sole;
      sole.heel_landing = n == 0 ? 0.5 : 0;
      sole.heel_n = sole.ball_n = n < 0.05 * rate ? 350 : 0;
      sole.ball_slope = n < 0.05 * rate ? 14000 : 0;
      sound.push_back(both(ground->next(sole)));
    }
    const Tone tone = tone_of(sound, rate, 0.16); // the joint is open
    CHECK(tone.frequency_hz == test::approx(900).epsilon(2e-3));
    CHECK(tone.t60_s == test::approx(0.2).epsilon(0.03));
  }
}

namespace {

/// A joint of 150 Hz and 20 g whose friction does not depend on speed; nothing differs from step to
/// step.
const std::string kJoint =
    "radiation 1\nfelt 1\n[friction]\nmodes 1\nfrequency 3000\nt60 0.003\n"
    "detune 0\nplace 0\nmass 100\nwobble 0\nvary_frequency 0\nvary_decay 0\n"
    "vary_level 0\nmu_s 0.8\nmu_d 0.3\nstribeck 0.001\nstiffness 4e6\ndamping 20\n"
    "viscosity 0\njoint 150\njoint_mass 0.02\njoint_t60 5\npressed 0\nload 10\n";

/// Mean time between two slips under a constant state of the sole, s.
double slip_interval(const std::string& more, SoleState sole) {
  const auto ground = ground_of(kJoint + more);
  std::vector<double> level;
  sole.heel_landing = 1e-12;
  for (int n = 0; n < 48000; ++n) {
    const double x = std::abs(both(ground->next(sole)));
    level.push_back(std::max(level.empty() ? 0 : 0.99 * level.back(), x));
    sole.heel_landing = 0;
  }
  const double high = *std::max_element(level.begin() + 9600, level.end());
  std::vector<double> times;
  bool loud = true;
  for (std::size_t n = 9600; n < level.size(); ++n) {
    const double t = static_cast<double>(n) / 48000;
    // A slip takes half a period of the joint, 3.3 ms. The sounds of its beginning and end count as
    // one.
    if (!loud && level[n] > 0.3 * high && (times.empty() || t > times.back() + 0.006))
      times.push_back(t);
    loud = level[n] > (loud ? 0.1 : 0.3) * high;
  }
  REQUIRE(times.size() > 5);
  return (times.back() - times.front()) / static_cast<double>(times.size() - 1);
}

/// A sole with these loads under heel and ball (N), which change at these rates (N/s).
SoleState loaded(double heel_n, double ball_n, double heel_slope, double ball_slope) {
  SoleState sole;
  sole.heel_n = heel_n;
  sole.ball_n = ball_n;
  sole.heel_slope = heel_slope;
  sole.ball_slope = ball_slope;
  return sole;
}

} // namespace

TEST_CASE("the time between slips follows from the joint's stiffness, friction and bending speed") {
  // A joint of stiffness K = m (2 pi f)^2 under the normal force N is stretched at the speed v. It
  // slips at the force mu_s N. Without losses the slip ends as far below mu_d N as it began above,
  // with large losses at mu_d N. So it is stretched by one to two times (mu_s - mu_d) N / K before
  // the next slip. 700 N/s of the load move from heel to ball.
  const auto slips = [](const std::string& more, double weights) {
    return slip_interval(more, loaded(350 * weights, 350 * weights, -700, 700));
  };
  // v = 0.01 m/s: `slip` 0.1 m/s is for 10 reference weights (700 N) a second, and one moves.
  const double stiffness = 0.02 * std::pow(2 * std::numbers::pi * 150, 2);
  const double expected = 2 * (0.8 - 0.3) * 10 / stiffness / 0.01;
  const double usual = slips("slip 0.1\n", 1);
  MESSAGE("a slip every " << usual << " s, without losses " << expected << " s");
  const auto between = [&](double time, double lossless) {
    CHECK(time > 0.5 * lossless);
    CHECK(time < lossless);
  };
  between(usual, expected);
  between(slips("slip 0.2\n", 2), expected);                      // twice the load, twice the speed
  between(slips("slip 0.2\njoint_mass 0.04\n", 2), expected / 2); // twice the stiffness
  between(slips("slip 0.1\nmu_s 0.55\n", 1), expected / 2);
  CHECK(slips("slip 0.2\n", 1) == test::approx(usual / 2).epsilon(0.1));
}

TEST_CASE("a floor springs back under a falling load by a small part of the load") {
  // The falling load bends the floor as if a part of it moved from ball to heel. The intervals of
  // both cases give that part.
  const double leaves = slip_interval("slip 0.1\n", loaded(0, 700, 0, -7000));
  const double back = slip_interval("slip 0.1\n", loaded(0, 700, 1400, -1400));
  const double part = 1400. / 7000 * back / leaves;
  MESSAGE("springs back by " << part << " of the load that leaves");
  CHECK(part > 0.12);
  CHECK(part < 0.28);
}

TEST_CASE("a rising load bends boards like a moving one of 0.7 to 0.9 of its rate") {
  const double moves = slip_interval("slip 0.1\n", loaded(350, 350, -700, 700));
  const double heel = slip_interval("slip 0.1\n", loaded(700, 0, 700, 0));
  const double ball = slip_interval("slip 0.1\n", loaded(0, 700, 0, 700));
  MESSAGE("bends by " << moves / heel << " of the load that comes");
  CHECK(moves / heel > 0.7);
  CHECK(moves / heel < 0.9);
  CHECK(ball == test::approx(heel).epsilon(0.02)); // wherever it comes
}

TEST_CASE(
    "boards do not spring free with a bang when their load is gone, or a tenth, in one sample") {
  for (const double left : {0., .1})
    for (int moment = 20000; moment < 24000; moment += 400) { // anywhere between two slips
      const auto ground = ground_of(kJoint + "slip 0.1\n");
      double creaks = 0, springs = 0;
      for (int n = 0; n < 36000; ++n) {
        const bool stands = n < moment;
        SoleState sole =
            stands ? loaded(350, 350, -700, 700) : loaded(350 * left, 350 * left, 0, 0);
        sole.heel_landing = n == 0 ? 1e-12 : 0;
        const double x = std::abs(both(ground->next(sole)));
        if (n > 9600)
          (stands ? creaks : springs) = std::max(stands ? creaks : springs, x);
      }
      CHECK(springs < 1.2 * creaks);
    }
}

TEST_CASE("a joint without load, or with a constant load, does not creak") {
  const auto power = [](double weights, double shift, double level) {
    const auto ground = ground_of("radiation 1\nfelt 1\n[friction]\nwobble 0\nlevel " +
                                  std::to_string(level) + "\n");
    double sum = 0;
    for (int n = 0; n < 9600; ++n) {
      SoleState sole = heel_at(n == 0 ? 1e-12 : 0);
      sole.heel_n = sole.ball_n = 350 * weights;
      sole.heel_slope = -700 * shift;
      sole.ball_slope = 700 * shift;
      const double x = both(ground->next(sole));
      sum += x * x;
    }
    return std::sqrt(sum);
  };
  CHECK(power(1, 10, 1) > 0);
  CHECK(power(1, 10, 4) == test::approx(4 * power(1, 10, 1)));
  CHECK(power(1, 0, 1) == 0);
  CHECK(power(0.009, 10, 1) == 0);
}

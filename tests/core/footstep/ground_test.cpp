#include "core/footstep/ground.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

// What the words of a recipe do to the sound of a ground, each alone and from its own definition.

using namespace tactus::footstep;

namespace {

Recipe recipe_of(const std::string& text) {
  Recipe recipe;
  INFO(text);
  REQUIRE(read_recipe(text, recipe) == "");
  return recipe;
}

std::unique_ptr<Ground> ground_of(const std::string& text, double rate = 48000,
                                  std::uint64_t seed = 1, double shoe = 0.4) {
  auto ground = std::make_unique<Ground>();
  ground->prepare(rate);
  ground->seed(seed);
  ground->set(recipe_of(text), shoe);
  return ground;
}

/// A plain floor of one linear contact and one mode, no step unlike another; `more` goes on in it.
std::string board(const std::string& more) {
  return "radiation 1\n[solid]\nmodes 1\nfrequency 400\ndetune 0\nt60 0.5\nplace 0\nexponent 1\n"
         "stiffness 1e6\ndissipation 0\nball 0\nvary_frequency 0\nvary_decay 0\nvary_level 0\n" +
         more;
}

/// A rustle, which is as loud as its energy: nothing else sets it going but what `more` says.
std::string rustle(const std::string& more) {
  return "radiation 1\n[rustle]\nattack 1e-4\ndecay 0.05\nheel 0\nball 0\nload 0\nrelease 0\n"
         "vary_frequency 0\nvary_decay 0\nvary_level 0\n" +
         more;
}

SoleState heel_at(double speed) {
  SoleState sole;
  sole.heel_landing = speed;
  return sole;
}

/// The ground's motion from one state of the sole in the first sample and none after.
std::vector<double> felt(Ground& ground, const SoleState& first, int samples = 4800) {
  std::vector<double> motion;
  motion.reserve(static_cast<std::size_t>(samples));
  for (int n = 0; n < samples; ++n)
    motion.push_back(ground.next(n == 0 ? first : SoleState{}, 700).felt);
  return motion;
}

double loudest(const std::vector<double>& sound) {
  double most = 0;
  for (const double x : sound)
    most = std::max(most, std::abs(x));
  return most;
}

/// The factor between two sounds of one shape; fails when they have not one shape.
double factor(const std::vector<double>& a, const std::vector<double>& b) {
  const double by = loudest(a) / loudest(b);
  double apart = 0;
  for (std::size_t n = 0; n < a.size(); ++n)
    apart = std::max(apart, std::abs(a[n] - by * b[n]));
  CHECK(apart < 1e-6 * loudest(a));
  return by;
}

/// Frequency from the times of rising zeros, and T60 from the peaks between them.
struct Tone {
  double frequency_hz, t60_s;
};
Tone tone_of(const std::vector<double>& x, double rate, double begin_s) {
  std::vector<double> zeros, peaks;
  double peak = 0;
  for (auto n = static_cast<std::size_t>(begin_s * rate) + 1; n < x.size(); ++n) {
    peak = std::max(peak, std::abs(x[n]));
    if (x[n - 1] <= 0 && x[n] > 0) {
      zeros.push_back((static_cast<double>(n) - x[n] / (x[n] - x[n - 1])) / rate);
      peaks.push_back(peak);
      peak = 0;
    }
  }
  REQUIRE(zeros.size() > 8);
  const double time = zeros.back() - zeros[1];
  return {static_cast<double>(zeros.size() - 2) / time,
          3 * std::numbers::ln10 * time / std::log(peaks[2] / peaks.back()) *
              (static_cast<double>(peaks.size() - 3) / static_cast<double>(peaks.size() - 2))};
}

double scatter(const std::vector<double>& values) {
  double sum = 0, square = 0;
  for (const double v : values) {
    sum += v / static_cast<double>(values.size());
    square += v * v / static_cast<double>(values.size());
  }
  return std::sqrt(square - sum * sum);
}

} // namespace

TEST_CASE(
    "mode i has the frequency f ratio^i, T60 ~ f^-t60_tilt and the gain f^-tilt, at any rate") {
  for (const double rate : {22050.0, 48000.0, 96000.0})
    for (int mode = 0; mode < 3; ++mode) {
      CAPTURE(rate);
      CAPTURE(mode);
      std::string gains = "gains";
      for (int i = 0; i < 3; ++i)
        gains += i == mode ? " 0" : " -120";
      const std::string text = "modes 3\nfrequency 300\nratio 1.5\nt60 0.4\nt60_tilt 0.7\n" + gains;
      const double relative = std::pow(1.5, mode);
      const auto ground = ground_of(board("tilt 0\n" + text), rate);
      const auto sound = felt(*ground, heel_at(0.5), static_cast<int>(0.25 * rate));
      const Tone tone = tone_of(sound, rate, 0.02);
      CHECK(tone.frequency_hz == doctest::Approx(300 * relative).epsilon(2e-3));
      CHECK(tone.t60_s == doctest::Approx(0.4 * std::pow(relative, -0.7)).epsilon(0.03));
      const auto tilted = ground_of(board("tilt 2\n" + text), rate);
      const auto softer = felt(*tilted, heel_at(0.5), static_cast<int>(0.25 * rate));
      CHECK(loudest(softer) / loudest(sound) ==
            doctest::Approx(std::pow(relative, -2)).epsilon(1e-3));
    }
}

TEST_CASE("boards that rub keep their frequency and decay at any sample rate") {
  for (const double rate : {22050.0, 48000.0, 96000.0}) {
    CAPTURE(rate);
    const auto ground = ground_of("radiation 1\n[friction]\nmodes 1\nfrequency 900\ndetune 0\n"
                                  "t60 0.5\nvary_frequency 0\nvary_decay 0\nvary_level 0\n",
                                  rate);
    std::vector<double> sound;
    for (int n = 0; n < 0.4 * rate; ++n) { // 50 ms of load that grows, then the foot lifts
      SoleState sole;
      sole.heel_landing = n == 0 ? 0.5 : 0;
      sole.heel_n = n < 0.05 * rate ? 700 : 0;
      sole.heel_slope = n < 0.05 * rate ? 7000 : 0;
      sound.push_back(ground->next(sole, 700).felt);
    }
    const Tone tone = tone_of(sound, rate, 0.1);
    CHECK(tone.frequency_hz == doctest::Approx(900).epsilon(2e-3));
    CHECK(tone.t60_s == doctest::Approx(0.5).epsilon(0.03));
  }
}

TEST_CASE("a linear contact is as loud as the landing is fast; the ball has its mass and share") {
  const auto heel = [](double speed, const std::string& more) {
    return felt(*ground_of(board(more)), heel_at(speed));
  };
  CHECK(factor(heel(1, ""), heel(0.25, "")) == doctest::Approx(4));
  CHECK(factor(heel(0.5, "level 3\n"), heel(0.5, "level 1\n")) == doctest::Approx(3));
  const auto ball = [](double speed, const std::string& more) {
    const auto ground = ground_of(board(more));
    felt(*ground, heel_at(0.5), 24000); // a place for the foot; the heel's blow has died away
    SoleState sole;
    sole.ball_landing = speed;
    return felt(*ground, sole);
  };
  // Twice the ball's speed is the heel's on the same mass.
  CHECK(factor(ball(0.3, "t60 0.03\nball 2\nball_mass 0.07\n"),
               heel(0.6, "t60 0.03\nheel 0.07\n")) == doctest::Approx(1));
  CHECK(loudest(ball(0.3, "t60 0.03\nball 0\n")) < 1e-9 * loudest(heel(0.3, "")));
  // A heavier mass brings more momentum.
  CHECK(loudest(heel(0.5, "heel 0.08\n")) > 1.2 * loudest(heel(0.5, "heel 0.04\n")));
}

TEST_CASE("a shoe multiplies the contact's stiffness by 10^(1.6 (shoe - 0.4))") {
  for (const double shoe : {0.0, 0.7, 1.0}) {
    const double stiffness = 1e6 * std::pow(10, 1.6 * (shoe - 0.4));
    const auto worn = ground_of(board(""), 48000, 1, shoe);
    const auto stiff = ground_of(board("stiffness " + std::to_string(stiffness) + "\n"));
    CHECK(factor(felt(*worn, heel_at(0.5)), felt(*stiff, heel_at(0.5))) ==
          doctest::Approx(1).epsilon(1e-6));
  }
}

TEST_CASE("a landing's energy goes with the square of its speed, up to 4 m/s, at 0.5 m/s as said") {
  const auto of = [](const std::string& text, const SoleState& sole) {
    return felt(*ground_of(rustle(text)), sole);
  };
  const auto usual = of("heel 1\n", heel_at(0.5));
  CHECK(factor(of("heel 3\n", heel_at(0.5)), usual) == doctest::Approx(3));
  CHECK(factor(of("heel 1\n", heel_at(1)), usual) == doctest::Approx(4));
  CHECK(factor(of("heel 1\n", heel_at(3.9)), usual) == doctest::Approx(std::pow(7.8, 2)));
  CHECK(factor(of("heel 1\n", heel_at(50)), usual) == doctest::Approx(64));
  SoleState sole;
  sole.ball_landing = 0.25;
  CHECK(factor(of("ball 2\n", sole), usual) == doctest::Approx(0.5));
  CHECK(loudest(of("heel 1\n", sole)) == 0);
  CHECK(loudest(of("ball 1\n", heel_at(0.5))) == 0);
  CHECK(factor(of("heel 1\nlevel 5\n", heel_at(0.5)), usual) == doctest::Approx(5));
  // The energy arrives in the attack: its rise passes 1 - 1/e there.
  const auto late = of("attack 0.02\ndecay 10\nheel 1\n", heel_at(0.5));
  const auto soon = of("attack 1e-4\ndecay 10\nheel 1\n", heel_at(0.5));
  for (const int n : {480, 960, 1920})
    CHECK(late[static_cast<std::size_t>(n)] / soon[static_cast<std::size_t>(n)] ==
          doctest::Approx(1 - std::exp(-(n + 1) / 960.)).epsilon(0.01));
}

TEST_CASE("load that comes gives energy by `load`, load that goes by `release`, in body weights") {
  const auto power = [](const std::string& text, double slope, double weight, bool ball = false) {
    const auto ground = ground_of(rustle(text));
    std::vector<double> motion;
    for (int n = 0; n < 2400; ++n) {
      SoleState sole;
      (ball ? sole.ball_slope : sole.heel_slope) = slope;
      sole.heel_n = 100;
      motion.push_back(ground->next(sole, weight).felt);
    }
    return motion;
  };
  const auto usual = power("load 1\n", 7000, 700);
  CHECK(factor(power("load 2\n", 7000, 700), usual) == doctest::Approx(2));
  CHECK(factor(power("load 1\n", 3500, 700), usual) == doctest::Approx(0.5));
  CHECK(factor(power("load 1\n", 7000, 350), usual) == doctest::Approx(2));
  CHECK(factor(power("load 1\n", 7000, 700, true), usual) == doctest::Approx(1));
  CHECK(factor(power("release 3\n", -7000, 700), usual) == doctest::Approx(3));
  CHECK(loudest(power("load 1\n", -7000, 700)) == 0);
  CHECK(loudest(power("release 1\n", 7000, 700)) == 0);
  // 200 weights a second are the steepest.
  CHECK(factor(power("load 1\n", 190 * 700, 700), usual) == doctest::Approx(19));
  CHECK(factor(power("load 1\n", 500 * 700, 700), usual) == doctest::Approx(20));
  CHECK(factor(power("release 1\n", -500 * 700, 700), usual) == doctest::Approx(20));
}

TEST_CASE("the air takes what the floor moves less and less below its frequency of radiation") {
  for (const double radiation : {40.0, 400.0, 4000.0}) {
    CAPTURE(radiation);
    Recipe recipe = recipe_of(board(""));
    recipe.radiation_hz = radiation;
    const auto ground = std::make_unique<Ground>();
    ground->prepare(96000);
    ground->set(recipe, 0.4);
    double heard = 0, motion = 0;
    for (int n = 0; n < 19200; ++n) {
      const Ground::Sound sound = ground->next(n == 0 ? heel_at(0.5) : SoleState{}, 700);
      if (n < 4800)
        continue;
      heard += sound.heard * sound.heard;
      motion += sound.felt * sound.felt;
    }
    // A first-order high-pass, 400 Hz through it.
    const double x = 400 / radiation;
    CHECK(std::sqrt(heard / motion) == doctest::Approx(x / std::sqrt(1 + x * x)).epsilon(0.04));
  }
}

TEST_CASE("steps differ by the recipe's scatter of frequency, decay and strength") {
  // Logarithms are normal, cut at 2.5 deviations: 0.984 of the deviation is left.
  std::vector<double> frequencies, decays, levels, tunings;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    const auto tone = [&](const std::string& more) {
      return tone_of(felt(*ground_of(board("t60 0.3\n" + more), 48000, seed), heel_at(0.5), 12000),
                     48000, 0.02);
    };
    frequencies.push_back(std::log(tone("vary_frequency 0.1\n").frequency_hz));
    decays.push_back(std::log(tone("vary_decay 0.2\n").t60_s));
    tunings.push_back(std::log(tone("detune 0.1\n").frequency_hz));
    levels.push_back(std::log(
        loudest(felt(*ground_of(board("vary_level 0.3\n"), 48000, seed), heel_at(0.5), 960))));
  }
  // A scatter of 150 values is known to 6 %; three of these.
  CHECK(scatter(frequencies) == doctest::Approx(0.0984).epsilon(0.18));
  CHECK(scatter(decays) == doctest::Approx(0.197).epsilon(0.18));
  CHECK(scatter(tunings) == doctest::Approx(0.1).epsilon(0.18));
  CHECK(scatter(levels) == doctest::Approx(0.295).epsilon(0.18));
}

TEST_CASE("each landing of the heel is another step on the same modes, the ball's is not") {
  const auto ground = ground_of(board("vary_frequency 0.2\n"));
  const auto tone = [&](const SoleState& sole) {
    return tone_of(felt(*ground, sole, 24000), 48000, 0.02).frequency_hz;
  };
  const double first = tone(heel_at(0.5)), second = tone(heel_at(0.5));
  CHECK(std::abs(std::log(second / first)) > 0.01);
  const auto both = ground_of(board("vary_frequency 0.2\nball 1\n"));
  const double heel = tone_of(felt(*both, heel_at(0.5), 24000), 48000, 0.02).frequency_hz;
  SoleState ball;
  ball.ball_landing = 0.5;
  CHECK(tone_of(felt(*both, ball, 24000), 48000, 0.02).frequency_hz ==
        doctest::Approx(heel).epsilon(1e-3));
}

TEST_CASE("boards rub by the weight on them, and as fast as it comes") {
  const auto power = [](const std::string& more, double weights, double slope, double heel = 1) {
    const auto ground =
        ground_of("radiation 1\n[friction]\nmodes 1\nfrequency 300\ndetune 0\n"
                  "t60 0.05\nwobble 0\nplace 0\nvary_frequency 0\nvary_decay 0\nvary_level 0\n" +
                  more);
    double sum = 0;
    for (int n = 0; n < 9600; ++n) {
      SoleState sole = heel_at(n == 0 ? 1e-12 : 0);
      sole.heel_n = 700 * weights * heel; // the rest under the ball
      sole.ball_n = 700 * weights * (1 - heel);
      sole.heel_slope = 700 * slope * heel;
      sole.ball_slope = 700 * slope * (1 - heel);
      const double x = ground->next(sole, 700).felt;
      sum += x * x;
    }
    return std::sqrt(sum / 9600);
  };
  const double usual = power("", 1, 10);
  CHECK(usual > 0);
  CHECK(power("level 4\n", 1, 10) == doctest::Approx(4 * usual));
  for (const double heel : {0.0, 0.3, 0.5})
    CHECK(power("", 1, 10, heel) == doctest::Approx(usual));
  CHECK(power("", 1, 0) == 0);      // nothing slips
  CHECK(power("", 0.009, 10) == 0); // nobody stands there
  // What slips 0.1 m/s at 10 weights a second slips 0.05 m/s at 5, and as said by `slip`.
  CHECK(power("slip 0.2\n", 1, 5) == doctest::Approx(usual));
  // 6 N and 20 N for a weight: 16 N under half of one, as much as 16 N without.
  CHECK(power("pressed 16\nload 0\n", 1, 10) == doctest::Approx(power("", 0.5, 10)));
}

TEST_CASE("a ground is silent before the first step, while nothing sounds, and after a reset") {
  for (const char* section : {"[solid]\nt60 0.05\n", "[friction]\nt60 0.05\n", "[grains]\nload 1\n",
                              "[bubbles]\nload 1\n", "[rustle]\nload 1\n"}) {
    CAPTURE(section);
    const auto ground = ground_of(section);
    const auto tread = [&](int samples) {
      double most = 0;
      for (int n = 0; n < samples; ++n) {
        SoleState sole = heel_at(n == 0 ? 1 : 0);
        sole.heel_n = 700;
        sole.heel_slope = 7000;
        most = std::max(most, std::abs(ground->next(sole, 700).felt));
        CHECK_FALSE(ground->silent());
      }
      return most;
    };
    CHECK(ground->silent());
    CHECK(ground->next({}, 700).felt == 0);
    CHECK(ground->silent());
    CHECK(tread(2000) > 0);
    CHECK_FALSE(ground->silent());
    int samples = 0;
    for (; samples < 48000 * 20 && !ground->silent(); ++samples)
      ground->next({}, 700);
    CHECK(ground->silent());
    CHECK(samples > 20);
    CHECK(ground->next({}, 700).heard == 0);
    CHECK(tread(2000) > 0);
    ground->reset();
    CHECK(ground->silent());
    CHECK(ground->next({}, 700).felt == 0);
  }
}

#include "core/contact/touched_body.hpp"
#include "core/footstep/ground.hpp"
#include "core/footstep/shoe.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

// What the words of a recipe do to the sound of a ground, each alone and from its own definition.

using namespace tactus::footstep;
namespace contact = tactus::contact;
namespace test = tactus::test;

namespace {

Recipe recipe_of(const std::string& text) {
  Recipe recipe;
  INFO(text);
  REQUIRE(read_recipe(text, recipe) == "");
  return recipe;
}

std::unique_ptr<Ground> ground_of(const std::string& text, double rate = 48000,
                                  std::uint64_t seed = 1, double shoe = 1) {
  auto ground = std::make_unique<Ground>();
  ground->prepare(rate);
  ground->seed(seed);
  ground->set(recipe_of(text), shoe);
  return ground;
}

/// A plain floor of one linear contact and one mode, no step unlike another; `more` goes on in it.
std::string board(const std::string& more) {
  return "radiation 1\nfelt 1\n[solid]\nmodes 1\nfrequency 400\ndetune 0\nt60 0.5\nplace "
         "0\npatches 1\n"
         "exponent 1\nstiffness 1e4\ndissipation 0\nball 0\nvary_frequency 0\nvary_decay "
         "0\nvary_level 0\n" +
         more;
}

/// A rustle, which is as loud as its energy: nothing else sets it going but what `more` says.
std::string rustle(const std::string& more) {
  return "radiation 1\nfelt 1\n[rustle]\nattack 1e-4\ndecay 0.05\nheel 0\nball 0\nload 0\nrelease "
         "0\n"
         "vary_frequency 0\nvary_decay 0\nvary_level 0\n" +
         more;
}

SoleState heel_at(double speed) {
  SoleState sole;
  sole.heel_landing = speed;
  return sole;
}

double both(const Ground::Sound& sound) { return sound.heel_felt + sound.ball_felt; }

/// The ground's motion from one state of the sole in the first sample and none after.
std::vector<double> felt(Ground& ground, const SoleState& first, int samples = 4800) {
  std::vector<double> motion;
  motion.reserve(static_cast<std::size_t>(samples));
  for (int n = 0; n < samples; ++n)
    motion.push_back(both(ground.next(n == 0 ? first : SoleState{})));
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
      CHECK(tone.frequency_hz == test::approx(300 * relative).epsilon(2e-3));
      CHECK(tone.t60_s == test::approx(0.4 * std::pow(relative, -0.7)).epsilon(0.03));
      const auto tilted = ground_of(board("tilt 2\n" + text), rate);
      const auto softer = felt(*tilted, heel_at(0.5), static_cast<int>(0.25 * rate));
      CHECK(loudest(softer) / loudest(sound) == test::approx(std::pow(relative, -2)).epsilon(1e-3));
    }
}

TEST_CASE("boards that rub keep their frequency and decay at any sample rate") {
  for (const double rate : {22050.0, 48000.0, 96000.0}) {
    CAPTURE(rate);
    const auto ground =
        ground_of("radiation 1\nfelt 1\n[friction]\nmodes 1\nfrequency 900\n"
                  "detune 0\nt60 0.05\npressed 0\njoint_t60 0.005\nvary_frequency 0\n"
                  "vary_decay 0\nvary_level 0\n",
                  rate);
    std::vector<double> sound;
    for (int n = 0; n < 0.4 * rate; ++n) { // 50 ms of load that moves, then the foot lifts
      SoleState sole;
      sole.heel_landing = n == 0 ? 0.5 : 0;
      sole.heel_n = sole.ball_n = n < 0.05 * rate ? 350 : 0;
      sole.ball_slope = n < 0.05 * rate ? 14000 : 0;
      sound.push_back(both(ground->next(sole)));
    }
    sound.resize(static_cast<std::size_t>(0.1 * rate));
    const Tone tone = tone_of(sound, rate, 0.055);
    CHECK(tone.frequency_hz == test::approx(900).epsilon(2e-3));
    CHECK(tone.t60_s == test::approx(0.05).epsilon(0.03));
  }
}

TEST_CASE("a linear contact is as loud as the landing is fast; the ball has its mass and share") {
  const auto heel = [](double speed, const std::string& more) {
    return felt(*ground_of(board(more)), heel_at(speed));
  };
  CHECK(factor(heel(1, ""), heel(0.25, "")) == test::approx(4));
  CHECK(factor(heel(0.5, "level 3\n"), heel(0.5, "level 1\n")) == test::approx(3));
  const auto ball = [](double speed, const std::string& more) {
    const auto ground = ground_of(board(more));
    felt(*ground, heel_at(0.5), 24000); // a place for the foot; the heel's blow has died away
    SoleState sole;
    sole.ball_landing = speed;
    return felt(*ground, sole);
  };
  // Twice the ball's speed is the heel's on the same mass.
  CHECK(factor(ball(0.3, "t60 0.03\nball 2\nball_mass 0.07\n"),
               heel(0.6, "t60 0.03\nheel 0.07\n")) == test::approx(1));
  CHECK(loudest(ball(0.3, "t60 0.03\nball 0\n")) < 1e-9 * loudest(heel(0.3, "")));
  // A heavier mass brings more momentum.
  CHECK(loudest(heel(0.5, "stiffness 1e7\nheel 0.08\n")) >
        1.2 * loudest(heel(0.5, "stiffness 1e7\nheel 0.04\n")));
}

TEST_CASE("a landing meets the law of ground and sole in series, and returns as they do") {
  // F = k1 d1^a = k2 d2^a at any force, d = d1 + d2.
  for (const double shoe : {0.0, 0.4, 1.0})
    for (const double exponent : {1.0, 1.6, 3.0}) {
      const contact::ImpactLaw ground{2e6, exponent, 0.2}, sole = sole_law(shoe, exponent);
      const contact::ImpactLaw one = in_series(ground, sole);
      for (const double force : {0.1, 30.0, 5000.0})
        CHECK(one.penetration(force) ==
              test::approx(ground.penetration(force) + sole.penetration(force)).epsilon(1e-9));
      // Alike and stiff: half as stiff for a spring; a soft one decides alone.
      CHECK(in_series(sole, sole).stiffness ==
            test::approx(sole.stiffness / std::pow(2, exponent)).epsilon(1e-9));
      contact::ImpactLaw rock = ground;
      rock.stiffness = 1e40;
      CHECK(in_series(rock, sole).dissipation_s_per_m ==
            test::approx(sole.dissipation_s_per_m).epsilon(0.01));
    }
  // 63 N and 160 kN indent a heel pad and steel by 1 mm.
  CHECK(sole_law(0, 1.6).force(1e-3, 0) == test::approx(63).epsilon(1e-9));
  CHECK(sole_law(1, 1.5).force(1e-3, 0) == test::approx(1.6e5).epsilon(1e-9));
  // The object's contact is that law's: one mode of 0.25 kg, struck by an elastic sole in series
  // with an elastic ground, moves as under one spring of their series.
  for (const double shoe : {0.0, 0.7}) {
    const contact::ImpactLaw one = in_series({1e4, 1, 0}, sole_law(shoe, 1));
    contact::TouchedBody body(1, 1, 1);
    body.prepare(48000);
    const std::array<contact::Mode, 1> modes{contact::Mode{400, 0.5, 0.25}};
    body.set_modes(modes);
    body.set_impact(0, one, 0.08);
    body.throw_mass(0, 0, 0.5);
    std::vector<double> expected;
    for (int n = 0; n < 4800; ++n) {
      body.step();
      expected.push_back(body.hear(0));
    }
    const auto worn = ground_of(board("mass 0.25\nheel 0.08\n"), 48000, 1, shoe);
    CHECK(factor(felt(*worn, heel_at(0.5)), expected) == test::approx(1).epsilon(1e-6));
  }
}

TEST_CASE("a soft sole quietens what lies between it and a floor, as the force of a landing") {
  const std::string floor = "[solid]\nlevel 0\nexponent 1.6\nstiffness 1e9\ndissipation 0\n";
  const auto loud = [](const std::string& text, double shoe) {
    return felt(*ground_of(text, 48000, 1, shoe), heel_at(0.5));
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

TEST_CASE("the parts of a sole share its mass and land one after the other, the slower the later") {
  // Contacts of a linear law far apart in time on a dead mode: each shows as one burst.
  const auto bursts = [](const std::string& more, double speed, std::uint64_t seed) {
    const auto ground = ground_of(
        board("t60 0.002\nstiffness 1e8\npatches 5\nunevenness 0.02\n" + more), 48000, seed, 1);
    const auto motion = felt(*ground, heel_at(speed), 48000);
    std::vector<int> onsets;
    int quiet = 1000;
    for (int n = 0; n < 48000; ++n) {
      if (std::abs(motion[static_cast<std::size_t>(n)]) > 1e-4) {
        if (quiet > 200)
          onsets.push_back(n);
        quiet = 0;
      } else {
        ++quiet;
      }
    }
    return onsets;
  };
  double count = 0, later = 0, last = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const auto found = bursts("", 1, seed);
    REQUIRE(!found.empty());
    CHECK(found[0] <= 2);
    count += static_cast<double>(found.size());
    last += found.back() / 48000.;
    // The same heights at half the speed take twice the time.
    later += bursts("", 0.5, seed).back() / 48000.;
  }
  // Four exponential heights of mean 20 mm at 1 m/s: the last arrives after 20 ms (1 + 1/2 + 1/3 +
  // 1/4) on average, within 3 standard errors (1.19 heights a landing); some arrive together.
  CHECK(count / 60 > 2.5);
  CHECK(count / 60 <= 5);
  CHECK(last / 60 == test::approx(0.0417).epsilon(0.25));
  CHECK(later / last == test::approx(2).epsilon(0.05));
}

TEST_CASE("a landing stirs particles as fast as it is, up to 4 m/s, at 0.5 m/s as said: power with "
          "its square") {
  const auto of = [](const std::string& text, const SoleState& sole) {
    return felt(*ground_of(rustle(text)), sole);
  };
  const auto usual = of("heel 1\n", heel_at(0.5));
  CHECK(factor(of("heel 3\n", heel_at(0.5)), usual) == test::approx(3));
  CHECK(factor(of("heel 1\n", heel_at(1)), usual) == test::approx(2));
  CHECK(factor(of("heel 1\n", heel_at(3.9)), usual) == test::approx(7.8));
  CHECK(factor(of("heel 1\n", heel_at(50)), usual) == test::approx(8));
  SoleState sole;
  sole.ball_landing = 0.25;
  CHECK(factor(of("ball 2\n", sole), usual) == test::approx(1));
  CHECK(loudest(of("heel 1\n", sole)) == 0);
  CHECK(loudest(of("ball 1\n", heel_at(0.5))) == 0);
  CHECK(factor(of("heel 1\nlevel 5\n", heel_at(0.5)), usual) == test::approx(5));
  // The energy arrives in the attack: its rise passes 1 - 1/e there.
  const auto late = of("attack 0.02\ndecay 10\nheel 1\n", heel_at(0.5));
  const auto soon = of("attack 1e-4\ndecay 10\nheel 1\n", heel_at(0.5));
  for (const int n : {480, 960, 1920})
    CHECK(late[static_cast<std::size_t>(n)] / soon[static_cast<std::size_t>(n)] ==
          test::approx(1 - std::exp(-(n + 1) / 960.)).epsilon(0.01));
}

TEST_CASE("load that comes gives energy by `load`, load that goes by `release`, in 700 N") {
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
  CHECK(loudest(power("load 1\n", -7000)) == 0);
  CHECK(loudest(power("release 1\n", 7000)) == 0);
  // 200 times 700 N a second are the steepest.
  CHECK(factor(power("load 1\n", 190 * 700), usual) == test::approx(19).epsilon(1e-6));
  CHECK(factor(power("load 1\n", 500 * 700), usual) == test::approx(20).epsilon(1e-6));
  CHECK(factor(power("release 1\n", -500 * 700), usual) == test::approx(20).epsilon(1e-6));
}

TEST_CASE("a heavier body brings more mass, more energy, and sinks in for longer") {
  const auto of = [](const std::string& text, double weight, const SoleState& sole) {
    const auto ground = ground_of(text);
    ground->set_weight(weight);
    return felt(*ground, sole, 9600);
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
  CHECK(loudest(of(board(""), 0, heel_at(0.5))) == 0);
  CHECK(loudest(of(rustle("heel 1\n"), 0, heel_at(0.5))) == 0);
}

TEST_CASE("a sole that slides stirs particles by force and way, and rubs the floor") {
  const auto slid = [](const std::string& text, double force, double speed, bool ball) {
    const auto ground = ground_of(text);
    std::vector<double> motion;
    for (int n = 0; n < 4800; ++n) {
      SoleState sole;
      (ball ? sole.ball_n : sole.heel_n) = force;
      (ball ? sole.ball_slip : sole.heel_slip) = speed;
      const Ground::Sound sound = ground->next(sole);
      REQUIRE((ball ? sound.heel_felt : sound.ball_felt) == 0);
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
    CHECK(loudest(slid(board("roughness 1\n"), 70, 0.5, ball)) > 1e-4);
    CHECK(loudest(slid(board("roughness 1\n"), 70, 0, ball)) == 0);
  }
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
      const Ground::Sound sound = ground->next(n == 0 ? heel_at(0.5) : SoleState{});
      if (n < 4800)
        continue;
      heard += sound.heard * sound.heard;
      motion += both(sound) * both(sound);
    }
    // A first-order high-pass, 400 Hz through it.
    const double x = 400 / radiation;
    CHECK(std::sqrt(heard / motion) == test::approx(x / std::sqrt(1 + x * x)).epsilon(0.04));
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
  CHECK(scatter(frequencies) == test::approx(0.0984).epsilon(0.18));
  CHECK(scatter(decays) == test::approx(0.197).epsilon(0.18));
  CHECK(scatter(tunings) == test::approx(0.1).epsilon(0.18));
  CHECK(scatter(levels) == test::approx(0.295).epsilon(0.18));
}

TEST_CASE("each step is on another place, its later landings are not") {
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

TEST_CASE("a loaded joint sticks and slips as often as its stiffness and friction say") {
  // A joint of K = m (2 pi f)^2 pulled at v: a slip takes the force from mu_s N past mu_d N to as
  // much below it, if nothing is lost on the way, and to mu_d N if all is. Between two slips it is
  // thus stretched by one to two times (mu_s - mu_d) N / K. Of the load, 700 N/s move from heel to
  // ball.
  const auto slips = [](const std::string& more, double weights) {
    const auto ground =
        ground_of("radiation 1\nfelt 1\n[friction]\nmodes 1\nfrequency 3000\nt60 0.003\n"
                  "detune 0\nplace 0\nmass 100\nwobble 0\nvary_frequency 0\nvary_decay 0\n"
                  "vary_level 0\nmu_s 0.8\nmu_d 0.3\nstribeck 0.001\nstiffness 4e6\ndamping 20\n"
                  "viscosity 0\njoint 150\njoint_mass 0.02\njoint_t60 5\npressed 0\nload 10\n" +
                  more);
    std::vector<double> level;
    for (int n = 0; n < 96000; ++n) {
      SoleState sole;
      sole.heel_landing = n == 0 ? 1e-12 : 0;
      sole.heel_n = sole.ball_n = 350 * weights;
      sole.heel_slope = -700;
      sole.ball_slope = 700;
      const double x = std::abs(both(ground->next(sole)));
      level.push_back(std::max(level.empty() ? 0 : 0.99 * level.back(), x));
    }
    const double high = *std::max_element(level.begin() + 9600, level.end());
    std::vector<double> times;
    bool loud = true;
    for (std::size_t n = 9600; n < level.size(); ++n) {
      const double t = static_cast<double>(n) / 48000;
      // A slip is over after half a period of the joint, 3.3 ms: letting go and sticking are one.
      if (!loud && level[n] > 0.3 * high && (times.empty() || t > times.back() + 0.006))
        times.push_back(t);
      loud = level[n] > (loud ? 0.1 : 0.3) * high;
    }
    REQUIRE(times.size() > 5);
    return (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  };
  // v: slip 0.1 m/s for 10 a second, 1 a second moves.
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

TEST_CASE("a joint that nobody loads, or no load that moves, does not creak") {
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

TEST_CASE("a ground is silent before the first step, while nothing sounds, and after a reset") {
  for (const char* section : {"[solid]\nt60 0.05\n", "[friction]\nt60 0.05\n", "[grains]\nload 1\n",
                              "[bubbles]\nload 1\n", "[rustle]\nload 1\n"}) {
    CAPTURE(section);
    const auto ground = ground_of(section);
    const auto tread = [&](int samples) {
      double most = 0;
      for (int n = 0; n < samples; ++n) {
        SoleState sole = heel_at(n == 0 ? 1 : 0);
        sole.heel_n = sole.ball_n = 350;
        sole.ball_slope = 7000;
        most = std::max(most, std::abs(both(ground->next(sole))));
        CHECK_FALSE(ground->silent());
      }
      return most;
    };
    CHECK(ground->silent());
    CHECK(both(ground->next({})) == 0);
    CHECK(ground->silent());
    CHECK(tread(2000) > 0);
    CHECK_FALSE(ground->silent());
    int samples = 0;
    for (; samples < 48000 * 20 && !ground->silent(); ++samples)
      ground->next({});
    CHECK(ground->silent());
    CHECK(samples > 20);
    CHECK(ground->next({}).heard == 0);
    CHECK(tread(2000) > 0);
    ground->reset();
    CHECK(ground->silent());
    CHECK(both(ground->next({})) == 0);
  }
}

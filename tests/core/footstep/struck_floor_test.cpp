#include "core/contact/excited_body.hpp"
#include "core/footstep/shoe.hpp"
#include "tests/approx.hpp"
#include "tests/core/footstep/plain_ground.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

// Floors that are struck and rubbed: modes, contacts, the sole in parts.

using namespace tactus::footstep;
using namespace tactus::test;
namespace contact = tactus::contact;
namespace test = tactus::test;

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
      const auto sound = vibration(*ground, heel_at(0.5), static_cast<int>(0.25 * rate));
      const Tone tone = tone_of(sound, rate, 0.02);
      CHECK(tone.frequency_hz == test::approx(300 * relative).epsilon(2e-3));
      CHECK(tone.t60_s == test::approx(0.4 * std::pow(relative, -0.7)).epsilon(0.03));
      const auto tilted = ground_of(board("tilt 2\n" + text), rate);
      const auto softer = vibration(*tilted, heel_at(0.5), static_cast<int>(0.25 * rate));
      CHECK(peak_amplitude(softer) / peak_amplitude(sound) ==
            test::approx(std::pow(relative, -2)).epsilon(1e-3));
    }
}

TEST_CASE("a linear contact is as loud as the landing is fast; the ball has its mass and share") {
  const auto heel = [](double speed, const std::string& more) {
    return vibration(*ground_of(board(more)), heel_at(speed));
  };
  CHECK(factor(heel(1, ""), heel(0.25, "")) == test::approx(4));
  CHECK(factor(heel(0.5, "level 3\n"), heel(0.5, "level 1\n")) == test::approx(3));
  const auto ball = [](double speed, const std::string& more) {
    const auto ground = ground_of(board(more));
    vibration(*ground, heel_at(0.5),
              24000); // a place for the foot; the heel's impact has died away
    SoleState sole;
    sole.ball_landing = speed;
    return vibration(*ground, sole);
  };
  // Twice the ball's speed is the heel's on the same mass.
  CHECK(factor(ball(0.3, "t60 0.03\nball 2\nball_mass 0.07\n"),
               heel(0.6, "t60 0.03\nheel 0.07\n")) == test::approx(1));
  CHECK(peak_amplitude(ball(0.3, "t60 0.03\nball 0\n")) < 1e-9 * peak_amplitude(heel(0.3, "")));
  // A heavier mass brings more momentum.
  CHECK(peak_amplitude(heel(0.5, "stiffness 1e7\nheel 0.08\n")) >
        1.2 * peak_amplitude(heel(0.5, "stiffness 1e7\nheel 0.04\n")));
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
    contact::ExcitedBody body(1, 1, 1);
    body.prepare(48000);
    const std::array<contact::Mode, 1> modes{contact::Mode{400, 0.5, 0.25}};
    body.set_modes(modes);
    body.set_impact(0, one, 0.08);
    body.launch_mass(0, 0, 0.5);
    std::vector<double> expected;
    for (int n = 0; n < 4800; ++n) {
      body.step();
      expected.push_back(body.pickup_velocity(0));
    }
    const auto worn = ground_of(board("mass 0.25\nheel 0.08\n"), 48000, 1, shoe);
    CHECK(factor(vibration(*worn, heel_at(0.5)), expected) == test::approx(1).epsilon(1e-6));
  }
}

namespace {

/// Contacts of a linear law far apart in time on a dead mode: each shows as one burst.
const std::string kDeadMode = "t60 0.002\nstiffness 1e8\nunevenness 0.02\n";

/// Samples in which a burst begins.
std::vector<std::size_t> bursts(const std::vector<double>& motion) {
  std::vector<std::size_t> onsets;
  int quiet = 1000;
  for (std::size_t n = 0; n < motion.size(); ++n) {
    if (std::abs(motion[n]) > 1e-4) {
      if (quiet > 200)
        onsets.push_back(n);
      quiet = 0;
    } else {
      ++quiet;
    }
  }
  return onsets;
}

} // namespace

TEST_CASE("the parts of a sole share its mass and land one after the other, the slower the later") {
  const auto landing = [](double speed, std::uint64_t seed) {
    const auto ground = ground_of(board(kDeadMode + "patches 5\n"), 48000, seed, 1);
    return bursts(vibration(*ground, heel_at(speed), 48000));
  };
  double count = 0, later = 0, last = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const auto found = landing(1, seed);
    REQUIRE(!found.empty());
    CHECK(found[0] <= 2);
    count += static_cast<double>(found.size());
    last += static_cast<double>(found.back()) / 48000;
    // The same heights at half the speed take twice the time.
    later += static_cast<double>(landing(0.5, seed).back()) / 48000;
  }
  // Four exponential heights of mean 20 mm at 1 m/s: the last arrives after 20 ms (1 + 1/2 + 1/3 +
  // 1/4) on average, within 3 standard errors (1.19 heights a landing); some arrive together.
  CHECK(count / 60 > 2.5);
  CHECK(count / 60 <= 5);
  CHECK(last / 60 == test::approx(0.0417).epsilon(0.25));
  CHECK(later / last == test::approx(2).epsilon(0.05));
}

TEST_CASE("parts removed from a sole do not land") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto ground = ground_of(board(kDeadMode + "patches 8\n"), 48000, seed, 1);
    vibration(*ground, heel_at(0.1), 48); // seven are still in the air, for 0.2 s on average
    ground->set(recipe_of(board(kDeadMode + "patches 1\n")), 1);
    const auto motion = vibration(*ground, heel_at(0.5), 48000);
    for (std::size_t n = 480; n < motion.size(); ++n)
      REQUIRE(std::abs(motion[n]) < 1e-4);
  }
}

TEST_CASE("a sliding sole pulls the floor by its bristles until it slips, then with mu_d") {
  // The mode is far above what moves it and follows at once: x = F / k, of which a tenth is turned
  // into motion up and down. The bristles of 0.1 MN/m give F = sigma_0 v t, sliding mu_d N.
  constexpr double kBristles = 1e5, kShare = 0.1, kSlidingCoefficient = 0.5, kForce = 350;
  const double omega = 2 * std::numbers::pi * 2000, decay = std::log(1000) / 0.01;
  const double stiffness = 0.25 * (omega * omega + decay * decay);
  for (const bool ball : {false, true}) {
    const auto slid = [&](double speed) {
      const auto ground = ground_of(board("frequency 2000\nt60 0.01\nmass 0.25\nroughness 0\n"));
      std::vector<double> motion;
      for (int n = 0; n < 4800; ++n) {
        SoleState sole;
        (ball ? sole.ball_n : sole.heel_n) = kForce;
        (ball ? sole.ball_slip : sole.heel_slip) = speed;
        motion.push_back(both(ground->next(sole)));
      }
      return motion;
    };
    for (const double speed : {0.002, 0.01}) {
      double mean = 0;
      const auto motion = slid(speed);
      for (std::size_t n = 960; n < 2400; ++n) // 20 to 50 ms: half a millimetre at most
        mean += motion[n] / 1440;
      CHECK(mean == test::approx(kShare * kBristles * speed / stiffness).epsilon(0.02));
    }
    double displacement = 0;
    for (const double velocity : slid(1))
      displacement += velocity / 48000;
    CHECK(displacement ==
          test::approx(kShare * kSlidingCoefficient * kForce / stiffness).epsilon(0.02));
  }
}

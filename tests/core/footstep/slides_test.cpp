#include "tests/core/footstep/gait_recording.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

// Scuffing, dragging and turning: ways along the ground, loads and times.

using namespace tactus::footstep;

namespace {

constexpr double kPi = std::numbers::pi;

} // namespace

TEST_CASE(
    "a scuff strikes and slides in the swing, under a load that the other foot does not bear") {
  OneShot scuff(3.1);
  const Walker walker{1.4, 700, 0.4};
  const Recording made = play(walker, 10, [&](Gait& gait, double t) {
    if (t == 0)
      gait.walk(true);
    if (scuff(t))
      gait.scuff(1);
  });
  const Recording plain = play(walker, 10, [&](Gait& gait, double t) {
    if (t == 0)
      gait.walk(true);
  });
  double slid = 0, largest = 0, difference = 0, heel = 0, from = 0, to = 0;
  for (std::size_t n = 0; n < made.samples.size(); ++n) {
    const SoleState& sole = made.samples[n][1];
    // Steps slide by their heels when they land.
    slid += sole.ball_slip / 48000;
    if (sole.ball_slip > 0) {
      from = from > 0 ? from : static_cast<double>(n) / 48000;
      to = static_cast<double>(n) / 48000;
      largest = std::max(largest, sole.ball_n);
      heel = std::max(heel, sole.heel_n);
    }
    difference = std::max(difference, std::abs(made.total(n) - plain.total(n)));
  }
  CHECK(heel == 0);
  CHECK(slid > 0.1);
  CHECK(slid < 0.2); // 10 to 20 cm
  CHECK(largest < 0.15 * 700);
  CHECK(largest > 0.03 * 700);
  CHECK(difference < 1e-6 * 700); // the sum of both feet is what it was
  // Between the foot's lift and its next landing.
  const auto off = made.of(Phase::kToeOff), down = made.of(Phase::kHeelDown);
  const auto lift = std::find_if(off.rbegin(), off.rend(),
                                 [&](const Event& e) { return e.foot == 1 && e.t < from; });
  const auto land = std::find_if(down.begin(), down.end(),
                                 [&](const Event& e) { return e.foot == 1 && e.t > from; });
  REQUIRE(lift != off.rend());
  REQUIRE(land != down.end());
  CHECK(from > lift->t + 0.05);
  CHECK(to < land->t);
  const auto balls = made.of(Phase::kBallDown, from - 0.001);
  CHECK(std::abs(balls[0].t - from) < 1e-3); // it strikes where it begins to slide
  CHECK(balls[0].speed < 0.4);
}

TEST_CASE("a scuff finds a swing whatever the speed, the way of walking and the moment") {
  for (const Style style : {Style::kWalk, Style::kRun, Style::kSneak, Style::kDownstairs})
    for (const double speed : {0.3, 1.4, 4.0})
      for (const double moment : {3.0, 3.13, 3.37, 3.5}) {
        OneShot scuff(moment);
        const Recording made = play(
            {speed, 700, 0.4, style}, 16,
            [&](Gait& gait, double t) {
              if (t == 0)
                gait.walk(true);
              if (scuff(t))
                gait.scuff(0);
            },
            8000);
        CAPTURE(static_cast<int>(style));
        CAPTURE(speed);
        CAPTURE(moment);
        double slid = 0;
        bool loaded = false;
        for (std::size_t n = made.at(moment); n < made.samples.size(); ++n) {
          const SoleState& sole = made.samples[n][0];
          if (sole.heel_n > 0.2 * 700 || sole.ball_n > 0.2 * 700)
            continue; // the contact of a step's ball slides by 3 mm
          slid += sole.ball_slip / 8000;
          loaded = loaded || (sole.ball_slip > 0 && sole.ball_n > 10 && sole.heel_n == 0);
        }
        double ends = 0, down = 0; // it is over before the foot comes down
        for (std::size_t n = made.at(moment); n < made.samples.size() && down == 0; ++n) {
          const SoleState& sole = made.samples[n][0];
          if (sole.ball_slip > 0 && sole.ball_n < 0.15 * 700 && sole.heel_n == 0)
            ends = static_cast<double>(n) / 8000;
          if (ends > 0 && (sole.heel_landing > 0 || (sole.ball_landing > 0 && ends > 0 &&
                                                     static_cast<double>(n) / 8000 > ends + 0.01)))
            down = static_cast<double>(n) / 8000;
        }
        if (style != Style::kDownstairs) // its ball lands first and slides, too
          CHECK(down - ends > 0.04);
        CHECK(loaded);
        CHECK(slid > 0.02);
      }
}

TEST_CASE("a dragged foot slides as far as it is told, under 30 % of the weight") {
  for (const auto& length_and_speed : {std::array{0.5, 0.5}, {0.05, 2.0}, {3.0, 0.4}, {1.0, 3.0}})
    for (const bool stands : {false, true}) {
      const double length = length_and_speed[0], speed = length_and_speed[1];
      CAPTURE(length);
      CAPTURE(stands);
      OneShot drag(3);
      const Recording made = play({1.4, 800, 0.4}, 14, [&](Gait& gait, double t) {
        if (stands && t == 0)
          gait.walk(true);
        if (stands && t > 0.5)
          gait.walk(false);
        if (drag(t))
          gait.drag(0, length, speed);
      });
      double slid = 0, fastest = 0, largest = 0, difference = 0;
      for (std::size_t n = made.at(3); n < made.samples.size(); ++n) {
        const SoleState& sole = made.samples[n][0];
        difference = std::max(difference, std::abs(sole.heel_slip - sole.ball_slip));
        slid += sole.ball_slip / 48000;
        fastest = std::max(fastest, sole.ball_slip);
        if (sole.ball_slip == fastest)
          largest = sole.heel_n + sole.ball_n;
        if (stands)
          difference = std::max(difference, std::abs(made.total(n) - 800));
      }
      CHECK(difference < 1e-6);
      CHECK(slid == doctest::Approx(length).epsilon(1e-3));
      CHECK(fastest == doctest::Approx(speed).epsilon(1e-6));
      CHECK(largest == doctest::Approx(0.3 * 800).epsilon(0.01));
      CHECK(made.force(made.samples.size() - 1, 0) == doctest::Approx(stands ? 400 : 0));
    }
}

TEST_CASE("a walker drags a foot for its swing, and the sum of both feet stays") {
  for (const double moment : {3.0, 3.2, 3.45}) {
    OneShot drag(moment);
    const auto steady = [](Gait& gait, double t) {
      if (t == 0)
        gait.walk(true);
    };
    const Recording made = play({1.1, 700, 0.4}, 8, [&](Gait& gait, double t) {
      steady(gait, t);
      if (drag(t))
        gait.drag(1, 0.4, 0.5);
    });
    const Recording plain = play({1.1, 700, 0.4}, 8, steady);
    double slid = 0, difference = 0;
    for (std::size_t n = 0; n < made.samples.size(); ++n) {
      slid += made.samples[n][1].ball_slip / 48000;
      difference = std::max(difference, std::abs(made.total(n) - plain.total(n)));
    }
    CHECK(slid == doctest::Approx(0.4).epsilon(1e-3));
    CHECK(difference < 0.01 * 700); // but for its touch
  }
}

TEST_CASE("a drag leaves the ground in time for the next landing, in short swings and long ones") {
  for (const auto& [style, speed] : {std::pair{Style::kWalk, 1.4}, {Style::kSneak, 0.4}}) {
    OneShot drag(6);
    const Recording made = play({speed, 700, 0.4, style}, 14, [&](Gait& gait, double t) {
      if (t == 0)
        gait.walk(true);
      if (drag(t))
        gait.drag(0, 0.3, 0.5);
    });
    double ends = 0;
    for (std::size_t n = made.at(6); n < made.samples.size(); ++n)
      if (made.samples[n][0].heel_slip > 0 && made.samples[n][0].ball_slip > 0)
        ends = static_cast<double>(n) / 48000;
    REQUIRE(ends > 6);
    double off = 0, down = 0;
    for (const Event& e : made.events) {
      if (e.foot == 0 && e.phase == Phase::kToeOff && e.t > ends && off == 0)
        off = e.t;
      if (e.foot == 0 && e.phase == Phase::kHeelDown && e.t > ends && down == 0)
        down = e.t;
    }
    CHECK(down - off == doctest::Approx(0.05).epsilon(0.02));
  }
}

TEST_CASE("a turn slides the ball under the load by the angle times two thirds of its radius") {
  for (const double degrees : {30.0, 90.0, 180.0}) {
    OneShot turn(3);
    const Recording made = play({1.4, 700, 0.4}, 8, [&](Gait& gait, double t) {
      if (t == 0)
        gait.walk(true);
      if (turn(t))
        gait.turn(degrees * kPi / 180, 0);
    });
    double slid = 0, under = 0, heel = 0;
    for (std::size_t n = made.at(3); n < made.samples.size(); ++n)
      for (const SoleState& sole : made.samples[n]) {
        slid += sole.ball_slip / 48000;
        under += sole.ball_slip * sole.ball_n / 48000;
        heel = std::max(heel, sole.ball_slip > 0 ? sole.heel_n : 0);
      }
    const double distance = degrees * kPi / 180 * 0.04 * 2 / 3;
    CHECK(slid == doctest::Approx(distance).epsilon(1e-3));
    CHECK(under / slid > 0.6 * 700); // under most of the weight
    CHECK(heel < 0.02 * 700);        // on the ball alone
  }
  // Without a walk it is one step.
  OneShot turn(0.1);
  const Recording made = play({1.4, 700, 0.4}, 3, [&](Gait& gait, double t) {
    if (turn(t))
      gait.turn(kPi / 2, 1);
  });
  CHECK(made.of(Phase::kHeelDown).size() == 1);
  CHECK(made.of(Phase::kHeelDown)[0].foot == 1);
}

TEST_CASE("a walker drags no farther than a stride") {
  OneShot drag(3);
  const Recording made = play({1.1, 700, 0.4}, 6, [&](Gait& gait, double t) {
    if (t == 0)
      gait.walk(true);
    if (drag(t))
      gait.drag(1, 9, 0.5);
  });
  double slid = 0;
  for (const auto& sample : made.samples)
    if (sample[1].heel_slip > 0 && sample[1].ball_slip > 0)
      slid += sample[1].ball_slip / 48000;
  GroundReaction reaction;
  reaction.set({1.1, 700, 0.4});
  CHECK(slid == doctest::Approx(1.1 * reaction.stride_s()).epsilon(0.001));
}

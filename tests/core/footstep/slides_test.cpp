#include "tests/core/footstep/gait_recording.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <utility>

// Scuffing, dragging and turning: ways along the ground, loads and times.

using namespace tactus::footstep;

namespace {

constexpr double kPi = std::numbers::pi;

} // namespace

TEST_CASE(
    "a scuff strikes and slides in the swing, under a load that the other foot does not bear") {
  const Walker walker{1.4, 700, 0.4};
  const Recording made = play(walker, 10, {kWalk, {3.1, [&](Gait& gait) { gait.scuff(1); }}});
  const Recording plain = play(walker, 10, {kWalk});
  double slid = 0, largest = 0, difference = 0, heel = 0, from = 0, to = 0;
  for (std::size_t n = 0; n < made.samples.size(); ++n) {
    const SoleState& sole = made.samples[n][1];
    // Steps slide by their heels when they land.
    slid += sole.ball_slip / made.rate;
    if (sole.ball_slip > 0) {
      from = from > 0 ? from : made.time(n);
      to = made.time(n);
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

namespace {

void check_scuffs(std::initializer_list<double> speeds, std::initializer_list<double> moments) {
  for (const Style style : {Style::kWalk, Style::kRun, Style::kSneak, Style::kDownstairs})
    for (const double speed : speeds)
      for (const double moment : moments) {
        const Recording made = play({speed, 700, 0.4, style}, 10,
                                    {kWalk, {moment, [&](Gait& gait) { gait.scuff(0); }}});
        CAPTURE(static_cast<int>(style));
        CAPTURE(speed);
        CAPTURE(moment);
        // The ball slides under a light load; the contact of a step's ball slides by 3 mm under
        // more.
        double slid = 0, ends = 0, down = 0;
        for (std::size_t n = made.at(moment); n < made.samples.size(); ++n) {
          const SoleState& sole = made.samples[n][0];
          if (sole.heel_n == 0 && sole.ball_n > 10 && sole.ball_n < 0.15 * 700) {
            slid += sole.ball_slip / made.rate;
            ends = sole.ball_slip > 0 && down == 0 ? made.time(n) : ends;
          }
          if (down == 0 && ends > 0 &&
              (sole.heel_landing > 0 || (sole.ball_landing > 0 && made.time(n) > ends + 0.01)))
            down = made.time(n);
        }
        CHECK(slid > 0.02);
        if (style != Style::kDownstairs) // its ball lands first and slides, too
          CHECK(down - ends > 0.04);     // it is over before the foot comes down
      }
}

} // namespace

TEST_CASE("a scuff finds a swing, and is over before the foot comes down") {
  check_scuffs({1.4}, {3.13});
}
TEST_CASE("a scuff finds a swing whatever the speed, the way of walking and the moment" *
          doctest::test_suite("slow")) {
  check_scuffs({0.3, 1.4, 4.0}, {3.0, 3.13, 3.37, 3.5});
}

TEST_CASE("a dragged foot slides as far as it is told, under 30 % of the weight") {
  for (const auto& length_and_speed : {std::array{0.5, 0.5}, {0.05, 2.0}, {3.0, 0.4}, {1.0, 3.0}})
    for (const bool stands : {false, true}) {
      const double length = length_and_speed[0], speed = length_and_speed[1];
      CAPTURE(length);
      CAPTURE(stands);
      std::vector<Act> acts{{3, [&](Gait& gait) { gait.drag(0, length, speed); }}};
      if (stands)
        acts.insert(acts.begin(), {kWalk, {0.5, kHalt.act}});
      const Recording made = play({1.4, 800, 0.4}, 14, acts);
      double slid = 0, fastest = 0, largest = 0, difference = 0;
      for (std::size_t n = made.at(3); n < made.samples.size(); ++n) {
        const SoleState& sole = made.samples[n][0];
        difference = std::max(difference, std::abs(sole.heel_slip - sole.ball_slip));
        slid += sole.ball_slip / made.rate;
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

TEST_CASE("a walker drags a foot for its swing, a stride at most, and the sum of both feet stays") {
  const Walker walker{1.1, 700, 0.4};
  GroundReaction reaction;
  reaction.set(walker);
  const double stride = 1.1 * reaction.stride_s();
  const Recording plain = play(walker, 6, {kWalk});
  struct Row {
    double moment, length, slid;
  };
  for (const Row& row : {Row{3, 0.4, 0.4}, {3.2, 0.4, 0.4}, {3.45, 0.4, 0.4}, {3, 9, stride}}) {
    const Recording made =
        play(walker, 6, {kWalk, {row.moment, [&](Gait& gait) { gait.drag(1, row.length, 0.5); }}});
    double slid = 0, difference = 0;
    for (std::size_t n = 0; n < made.samples.size(); ++n) {
      const SoleState& sole = made.samples[n][1];
      slid += sole.heel_slip > 0 && sole.ball_slip > 0 ? sole.ball_slip / made.rate : 0;
      difference = std::max(difference, std::abs(made.total(n) - plain.total(n)));
    }
    CAPTURE(row.moment);
    CHECK(slid == doctest::Approx(row.slid).epsilon(1e-3));
    if (row.slid < 1)
      CHECK(difference < 0.01 * 700); // but for its touch
  }
}

TEST_CASE("a drag leaves the ground in time for the next landing, in short swings and long ones") {
  for (const auto& [style, speed] : {std::pair{Style::kWalk, 1.4}, {Style::kSneak, 0.4}}) {
    const Recording made = play({speed, 700, 0.4, style}, 14,
                                {kWalk, {6, [&](Gait& gait) { gait.drag(0, 0.3, 0.5); }}});
    double ends = 0;
    for (std::size_t n = made.at(6); n < made.samples.size(); ++n)
      if (made.samples[n][0].heel_slip > 0 && made.samples[n][0].ball_slip > 0)
        ends = made.time(n);
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
    const Recording made = play(
        {1.4, 700, 0.4}, 8, {kWalk, {3, [&](Gait& gait) { gait.turn(degrees * kPi / 180, 0); }}});
    double slid = 0, under = 0, heel = 0;
    for (std::size_t n = made.at(3); n < made.samples.size(); ++n)
      for (const SoleState& sole : made.samples[n]) {
        slid += sole.ball_slip / made.rate;
        under += sole.ball_slip * sole.ball_n / made.rate;
        heel = std::max(heel, sole.ball_slip > 0 ? sole.heel_n : 0);
      }
    const double distance = degrees * kPi / 180 * 0.04 * 2 / 3;
    CHECK(slid == doctest::Approx(distance).epsilon(1e-3));
    CHECK(under / slid > 0.6 * 700); // under most of the weight
    CHECK(heel < 0.02 * 700);        // on the ball alone
  }
  // Without a walk it is one step.
  const Recording made =
      play({1.4, 700, 0.4}, 3, {{0.1, [&](Gait& gait) { gait.turn(kPi / 2, 1); }}});
  CHECK(made.of(Phase::kHeelDown).size() == 1);
  CHECK(made.of(Phase::kHeelDown)[0].foot == 1);
}

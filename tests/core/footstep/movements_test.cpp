#include "core/dsp/random.hpp"
#include "tests/core/footstep/gait_recording.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

// Setting off, halting, jumping, and whatever is asked: momentum and times.

using namespace tactus::footstep;

TEST_CASE("a walker who halts closes the step, stands on both feet, and sets off again") {
  for (const Style style :
       {Style::kWalk, Style::kRun, Style::kSneak, Style::kUpstairs, Style::kDownstairs}) {
    CAPTURE(static_cast<int>(style));
    const Recording made =
        play({1.4, 700, 0.4, style}, 20, {kWalk, {3, kHalt.act}, {9, kWalk.act}, {13, kHalt.act}});
    // Two more landings of each part: the last step and the closing one, each softer.
    const bool ball_first = style == Style::kUpstairs || style == Style::kDownstairs;
    const auto landings = made.of(ball_first ? Phase::kBallDown : Phase::kHeelDown);
    const auto between = [&](double from, double to) {
      std::vector<Event> found;
      for (const Event& one : landings)
        if (one.t >= from && one.t < to)
          found.push_back(one);
      return found;
    };
    const auto last = between(3, 9);
    REQUIRE(last.size() == 2);
    CHECK(last[0].foot != last[1].foot);
    double difference = 1; // of heel and ball of the closing foot: it is put down nearly flat
    for (const Event& e : made.of(ball_first ? Phase::kHeelDown : Phase::kBallDown, last[1].t))
      difference = std::min(difference, e.t - last[1].t);
    CHECK(difference < 0.1);
    const double usual = between(0, 3).back().speed;
    CHECK(last[0].speed < 0.9 * usual);
    CHECK(last[1].speed < 0.9 * last[0].speed);
    // Half of the weight each, at rest, 60 % on the heels.
    for (std::size_t foot = 0; foot < 2; ++foot) {
      const SoleState& sole = made.samples[made.at(8.5)][foot];
      CHECK(sole.heel_n == doctest::Approx(0.6 * 350));
      CHECK(sole.ball_n == doctest::Approx(0.4 * 350));
      CHECK(sole.heel_slope == 0);
    }
    // Setting off takes a shift of weight; the first landings are softer than those that follow.
    const auto first = between(9, 13);
    REQUIRE(first.size() >= 3);
    CHECK(first[0].t - 9 > 0.7);
    CHECK(first[0].t - 9 < 1.8);
    CHECK(first[0].speed < first[1].speed);
    CHECK(first[1].speed < first[2].speed);
    CHECK(first[0].foot != first[1].foot);
    // From standing to standing no momentum is won or lost: 0.02 m/s, of 1.4 along the ground.
    CHECK(std::abs(made.velocity(8.9, 19.5, 700)) < 0.02);
    // While the weight is shifted one foot leaves the ground and the other does not.
    const auto off = made.of(Phase::kToeOff, 9);
    CHECK(off[0].t - 9 == doctest::Approx(0.42).epsilon(0.01));
    CHECK(off[0].foot == first[0].foot);
    double carried = 0;
    for (std::size_t n = made.at(9); n < made.at(9.7); ++n)
      carried += made.total(n) / made.rate;
    CHECK(carried == doctest::Approx(0.7 * 700).epsilon(2e-3));
  }
}

TEST_CASE("a standing foot leaves the ground in 150 ms: its load sinks, its heel goes first") {
  Footfall foot = lift(350);
  double heel_up = 0, toe_off = 0, impulse = 0, late_heel = 0, before = 350;
  for (int n = 1; n <= 9600 && toe_off == 0; ++n) {
    SoleState sole;
    foot.advance(1.0 / 48000, sole);
    const double force = sole.heel_n + sole.ball_n, t = n / 48000.0;
    CHECK(force <= before);
    before = force;
    impulse += force / 48000;
    if (sole.heel_up)
      heel_up = t;
    if (sole.toe_off)
      toe_off = t;
    if (t > 0.1 + 1e-9)
      late_heel = std::max(late_heel, sole.heel_n);
  }
  CHECK(std::abs(toe_off - 0.15) < 1e-4);
  CHECK(std::abs(heel_up - 0.08) < 1e-4);
  CHECK(late_heel < 1e-9);
  CHECK(std::abs(impulse - 350 * 0.15 / 2) < 0.01); // half a cosine
}

TEST_CASE("a jump is ballistic: the push-off gives v = sqrt(2 g h), the landing takes it") {
  for (const double height : {0.01, 0.05, 0.15, 0.3, 0.5, 1.0})
    for (const double weight : {400.0, 1000.0}) {
      CAPTURE(height);
      const Recording made =
          play({1.4, weight, 0.4}, 5, {{0.1, [&](Gait& gait) { gait.jump(height); }}});
      const double speed = std::sqrt(2 * kGravity * height);
      const auto off = made.of(Phase::kToeOff), up = made.of(Phase::kHeelUp);
      REQUIRE(off.size() == 2);
      CHECK(off[0].t == off[1].t); // both feet
      CHECK(up[0].t < off[0].t);
      const auto balls = made.of(Phase::kBallDown, off[0].t),
                 heels = made.of(Phase::kHeelDown, off[0].t);
      REQUIRE(balls.size() == 2);
      REQUIRE(heels.size() == 2);
      CHECK(balls[0].t - off[0].t == doctest::Approx(2 * speed / kGravity).epsilon(0.001));
      CHECK(balls[0].t == balls[1].t);
      CHECK(heels[0].t > balls[0].t + 0.01);
      CHECK(balls[0].speed == doctest::Approx(speed).epsilon(1e-9));
      CHECK(heels[0].speed < balls[0].speed);
      // Standing 0.3 s after the message, when the feet have been put down.
      const double stood = 0.4003;
      CHECK(made.total(made.at(stood)) == doctest::Approx(weight).epsilon(0.01));
      CHECK(made.velocity(stood, off[0].t, weight) == doctest::Approx(speed).epsilon(0.01));
      double air = 0;
      for (std::size_t n = made.at(off[0].t) + 1; n < made.at(balls[0].t); ++n)
        air = std::max(air, made.total(n));
      CHECK(air == 0);
      CHECK(made.velocity(balls[0].t, 4.9, weight) == doctest::Approx(speed).epsilon(0.01));
      double push = 0, landing = 0;
      for (std::size_t n = 0; n < made.samples.size(); ++n)
        (n < made.at(off[0].t) ? push : landing) =
            std::max(n < made.at(off[0].t) ? push : landing, made.total(n));
      CHECK(push / weight > 2);
      CHECK(push / weight < 4.5);
      CHECK(landing / weight == doctest::Approx(1 + 5.5 * std::sqrt(height)).epsilon(0.3));
      if (height >= 0.3 && height <= 0.5) {
        CHECK(push / weight < 3.2);
        CHECK(landing / weight > 3);
        CHECK(landing / weight < 5);
      }
      CHECK(made.total(made.at(4.9)) == doctest::Approx(weight)); // stands
    }
}

TEST_CASE("the feet of an unsteady walker land from a jump with variation") {
  const Recording made =
      play({1.1, 700, 0.4}, 3, {{0.1, [&](Gait& gait) { gait.jump(0.3); }}}, 8000, 0.04);
  const auto balls = made.of(Phase::kBallDown, 1);
  REQUIRE(balls.size() == 2);
  CHECK(balls[0].speed != balls[1].speed);
  CHECK(balls[0].speed / balls[1].speed == doctest::Approx(1).epsilon(0.4));
}

TEST_CASE("a walker halts to jump and walks on after it") {
  const Recording made =
      play({1.4, 700, 0.4}, 9, {kWalk, {3.2, [&](Gait& gait) { gait.jump(0.2); }}});
  const double flight = 2 * std::sqrt(2 * 0.2 / kGravity);
  std::vector<double> air; // starts of times with no force at all
  for (std::size_t n = 1; n < made.samples.size(); ++n)
    if (made.total(n) == 0 && made.total(n - 1) > 0)
      air.push_back(made.time(n));
  REQUIRE(air.size() == 1);
  CHECK(air[0] > 3.2 + 1);
  CHECK(air[0] < 3.2 + 3);
  CHECK(made.of(Phase::kHeelDown, air[0] + flight + 0.2).size() >= 3);
  CHECK(std::abs(made.velocity(air[0] - 0.78 * std::sqrt(0.2 / 0.3), air[0] + flight + 0.45, 700)) <
        0.05);
}

TEST_CASE(
    "a step from standing takes the feet off the ground; the standing feet stay with others") {
  const Recording made =
      play({1.4, 700, 0.4}, 9, {kWalk, {1, kHalt.act}, {6, [](Gait& gait) { gait.step(0); }}});
  CHECK(made.total(made.at(5.9)) == doctest::Approx(700));
  CHECK(made.of(Phase::kHeelDown, 6).size() == 1);
  CHECK(made.total(made.at(8.9)) == 0);
}

TEST_CASE("times, distances and impulses are the same at any sample rate") {
  const auto sequence = [](double rate) {
    return play({1.4, 700, 0.4}, 18,
                {kWalk,
                 {3, [&](Gait& gait) { gait.jump(0.3); }},
                 {7.5, [&](Gait& gait) { gait.scuff(0); }},
                 {9, [&](Gait& gait) { gait.turn(1.5, 0); }},
                 {11, kHalt.act},
                 {14.5, [&](Gait& gait) { gait.drag(1, 0.3, 0.4); }}},
                rate);
  };
  const Recording reference = sequence(16000);
  for (const double rate : {8000.0, 22050.0}) {
    const Recording made = sequence(rate);
    REQUIRE(made.events.size() == reference.events.size());
    for (std::size_t i = 0; i < made.events.size(); ++i) {
      CHECK(std::abs(made.events[i].t - reference.events[i].t) < 12 / std::min(rate, 16000.));
      CHECK(made.events[i].speed == doctest::Approx(reference.events[i].speed));
      CHECK(made.events[i].phase == reference.events[i].phase);
    }
    CHECK(made.velocity(0, 17.9, 700) ==
          doctest::Approx(reference.velocity(0, 17.9, 700)).epsilon(0.01));
  }
}

TEST_CASE("a reset lifts both feet and cancels pending movements") {
  Gait gait;
  gait.prepare(8000);
  gait.set({1.4, 700, 0.4}, 0);
  gait.walk(true);
  std::array<SoleState, 2> feet{};
  for (int n = 0; n < 9000; ++n)
    gait.next(feet);
  gait.jump(0.4);
  gait.scuff(0);
  gait.drag(1, 1, 1);
  gait.walk(false);
  for (int n = 0; n < 10000; ++n)
    gait.next(feet);
  gait.turn(1, 0);
  gait.jump(0.3);
  gait.scuff(0);
  gait.drag(1, 1, 1);
  gait.reset();
  bool any = false;
  for (int n = 0; n < 40000; ++n) {
    gait.next(feet);
    for (const SoleState& sole : feet)
      any = any || sole.heel_n + sole.ball_n + sole.heel_slip + sole.ball_slip != 0;
  }
  CHECK_FALSE(any);
}

TEST_CASE(
    "steps on command during a halt, a stand or a jump do not keep a walker from walking on") {
  std::size_t foot = 0;
  for (const double moment : {2.1, 2.5, 3.0, 4.0, 5.3, 5.6, 6.1, 6.5}) {
    foot = 1 - foot;
    CAPTURE(moment);
    const Recording made = play({1.4, 700, 0.4}, 15,
                                {kWalk,
                                 {2, kHalt.act},
                                 {5, [](Gait& gait) { gait.jump(0.2); }},
                                 {8, kWalk.act},
                                 {moment,
                                  [&](Gait& gait) {
                                    for (int i = 0; i < 9; ++i)
                                      gait.step(foot);
                                  }}},
                                8000, 0, false);
    CHECK(made.of(Phase::kHeelDown, 11).size() >= 6);
    double sum = 0;
    for (std::size_t n = made.at(11); n < made.samples.size(); ++n)
      sum += made.total(n) / 8000 / 4;
    CHECK(sum == doctest::Approx(700).epsilon(0.05)); // nothing is left standing
  }
}

namespace {

void check_any_messages(int rounds) {
  tactus::Random random(11);
  const double odd[] = {std::nan(""),
                        std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity(),
                        1e300,
                        -1e300,
                        0,
                        1e-310};
  Gait gait;
  gait.prepare(8000);
  std::array<SoleState, 2> feet{};
  for (int round = 0; round < rounds; ++round) {
    const auto number = [&](double max_value) {
      return random.uniform() < 0.1 ? odd[random.next() % 7] : max_value * random.uniform();
    };
    const auto foot = static_cast<std::size_t>(random.next() % 3);
    switch (random.next() % 8) {
    case 0:
      gait.set({number(10), number(2000), number(1.2), static_cast<Style>(random.next() % 5)},
               number(0.6));
      break;
    case 1:
      gait.walk(random.uniform() < 0.6);
      break;
    case 2:
      gait.step(foot);
      break;
    case 3:
      gait.turn(number(4), foot % 2);
      break;
    case 4:
      gait.jump(number(2));
      break;
    case 5:
      gait.scuff(foot);
      break;
    case 6:
      gait.drag(foot, number(3), number(6));
      break;
    default:
      if (random.uniform() < 0.1)
        gait.reset();
    }
    bool good = true;
    for (int n = static_cast<int>(random.uniform() * 4000); n > 0; --n) {
      gait.next(feet);
      for (const SoleState& sole : feet) {
        const double slip = sole.heel_slip + sole.ball_slip;
        good = good && std::isfinite(sole.heel_slope + sole.ball_slope) && sole.heel_n >= 0 &&
               sole.ball_n >= 0 && sole.heel_n + sole.ball_n < 3e7 && slip >= 0 && slip < 12 &&
               sole.heel_landing < 18 && sole.ball_landing < 18;
      }
    }
    REQUIRE(good);
  }
}

} // namespace

TEST_CASE("forces stay finite and bounded for any sequence of messages") {
  check_any_messages(150);
}
TEST_CASE("forces stay bounded for 4000 messages" * doctest::test_suite("slow")) {
  check_any_messages(4000);
}

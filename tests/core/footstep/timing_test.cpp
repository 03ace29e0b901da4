#include "core/footstep/drive.hpp"
#include "core/footstep/gait.hpp"
#include "core/footstep/room.hpp"
#include "core/footstep/sole_sensor.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

// Times, sizes and limits of gait, sensors and drives, each from its own definition.

using namespace tactus::footstep;

namespace {

constexpr double kRate = 48000;
constexpr double kPi = std::numbers::pi;

/// What happens to one foot, times in s.
struct Events {
  std::vector<double> heel, ball, heel_up, toe_off;
  std::vector<double> heel_speed, ball_speed;
};

Events walk(const Walker& walker, double seconds, std::size_t foot, double variation = 0) {
  Gait gait;
  gait.prepare(kRate);
  gait.set(walker, variation);
  gait.walk(true);
  Events events;
  std::array<SoleState, Gait::kFeet> feet{};
  for (int n = 0; n < seconds * kRate; ++n) {
    gait.next(feet);
    const SoleState& sole = feet[foot];
    if (sole.heel_landing > 0) {
      events.heel.push_back(n / kRate);
      events.heel_speed.push_back(sole.heel_landing);
    }
    if (sole.ball_landing > 0) {
      events.ball.push_back(n / kRate);
      events.ball_speed.push_back(sole.ball_landing);
    }
    if (sole.heel_up)
      events.heel_up.push_back(n / kRate);
    if (sole.toe_off)
      events.toe_off.push_back(n / kRate);
  }
  return events;
}

/// Sole forces that rise and fall along straight lines between (s, N).
struct Line {
  std::vector<std::array<double, 2>> points;
  [[nodiscard]] double at(double t) const {
    if (t <= points.front()[0])
      return points.front()[1];
    for (std::size_t i = 1; i < points.size(); ++i)
      if (t < points[i][0])
        return points[i - 1][1] + (points[i][1] - points[i - 1][1]) * (t - points[i - 1][0]) /
                                      (points[i][0] - points[i - 1][0]);
    return points.back()[1];
  }
};

struct Sensed {
  std::vector<double> heel_landing_s, heel_speed, ball_landing_s, ball_speed, heel_up_s, toe_off_s;
};

Sensed sense(const Line& heel, const Line& ball, double seconds, double weight = 700) {
  SoleSensor sensor;
  sensor.prepare(kRate);
  sensor.set(weight);
  Sensed sensed;
  for (int n = 0; n < seconds * kRate; ++n) {
    const double t = n / kRate;
    const SoleState sole = sensor.next(heel.at(t), ball.at(t));
    if (sole.heel_landing > 0) {
      sensed.heel_landing_s.push_back(t);
      sensed.heel_speed.push_back(sole.heel_landing);
    }
    if (sole.ball_landing > 0) {
      sensed.ball_landing_s.push_back(t);
      sensed.ball_speed.push_back(sole.ball_landing);
    }
    if (sole.heel_up)
      sensed.heel_up_s.push_back(t);
    if (sole.toe_off)
      sensed.toe_off_s.push_back(t);
  }
  return sensed;
}

} // namespace

TEST_CASE("a gait without variation keeps the times and speeds of its walker") {
  for (const Walker& walker :
       {Walker{.9, 700, .2}, Walker{1.4, 700, .2}, Walker{3, 650, .2, Style::kRun}}) {
    CAPTURE(walker.speed_m_per_s);
    GroundReaction reaction;
    reaction.set(walker);
    const double stride = reaction.stride_s(), stance = reaction.stance_s();
    const bool run = walker.style == Style::kRun;
    const double v = walker.speed_m_per_s, heel = run ? .6 + .15 * v : .5 * std::pow(v / 1.4, .8);
    for (const std::size_t foot : {0UL, 1UL}) {
      const Events e = walk(walker, 6, foot);
      REQUIRE(e.heel.size() >= 5);
      REQUIRE(e.toe_off.size() >= 4);
      for (std::size_t k = 0; k < 4; ++k) {
        const double begin = static_cast<double>(k) * stride + (foot ? stride / 2 : 0);
        CHECK(e.heel[k] == doctest::Approx(begin).epsilon(1e-9).scale(3 / kRate / 1e-9));
        CHECK(std::abs(e.ball[k] - e.heel[k] - (run ? .04 : .11) * stance) < 2 / kRate);
        CHECK(std::abs(e.heel_up[k] - e.heel[k] - .62 * stance) < 2 / kRate);
        CHECK(std::abs(e.toe_off[k] - e.heel[k] - stance) < 2 / kRate);
        const double softer = k > 0 ? 1 : foot == 0 ? .75 : .9; // the first two
        CHECK(e.heel_speed[k] == doctest::Approx(softer * heel));
        CHECK(e.ball_speed[k] == doctest::Approx(softer * .6 * heel));
      }
    }
  }
  CHECK(walk({20, 700, 0, Style::kRun}, 1, 0).heel_speed[0] ==
        walk({8, 700, 0, Style::kRun}, 1, 0).heel_speed[0]);
  CHECK(walk({.1, 700, 0}, 1, 0).heel_speed[0] == walk({.3, 700, 0}, 1, 0).heel_speed[0]);
  CHECK(walk({9, 700, 0}, 1, 0).heel_speed[0] == walk({2.5, 700, 0}, 1, 0).heel_speed[0]);
  CHECK(walk({1.4, 700, 0}, 4, 0, 9).heel == walk({1.4, 700, 0}, 4, 0, .5).heel);
}

TEST_CASE("slopes are the forces' differences, and a scatter of forces is the variation's") {
  Gait gait;
  gait.prepare(kRate);
  gait.set({1.4, 700, .4}, .04);
  gait.walk(true);
  std::array<SoleState, Gait::kFeet> feet{};
  double before_heel = 0, before_ball = 0, worst = 0, impulse = 0;
  std::vector<double> impulses, speeds;
  for (int n = 0; n < 300 * kRate; ++n) {
    gait.next(feet);
    const SoleState& sole = feet[0];
    if (sole.heel_landing > 0)
      speeds.push_back(std::log(sole.heel_landing));
    if (sole.heel_n > 0 && before_heel > 0) {
      worst = std::max(worst, std::abs(sole.heel_slope - (sole.heel_n - before_heel) * kRate));
      worst = std::max(worst, std::abs(sole.ball_slope - (sole.ball_n - before_ball) * kRate));
    }
    before_heel = sole.heel_n;
    before_ball = sole.ball_n;
    impulse += (sole.heel_n + sole.ball_n) / kRate;
    if (sole.toe_off)
      impulses.push_back(std::log(std::exchange(impulse, 0)));
  }
  CHECK(worst < 1e-4);
  const auto scatter = [](const std::vector<double>& x) {
    double sum = 0, square = 0;
    for (const double v : x) {
      sum += v / static_cast<double>(x.size());
      square += v * v / static_cast<double>(x.size());
    }
    return std::sqrt(square - sum * sum);
  };
  REQUIRE(impulses.size() > 250); // standard error of a scatter: 4.5 %
  CHECK(scatter(impulses) == doctest::Approx(.04 * std::sqrt(2.)).epsilon(.18)); // force and stance
  CHECK(scatter(speeds) == doctest::Approx(.16).epsilon(.18));
}

TEST_CASE("walking begins at once from the air; single steps are steps") {
  Gait gait;
  gait.prepare(kRate);
  gait.set({1.4, 700, 0}, 0);
  std::array<SoleState, Gait::kFeet> feet{};
  gait.next(feet);
  CHECK(feet[0].heel_landing == 0);
  CHECK_FALSE(gait.walking());
  gait.walk(true);
  CHECK(gait.walking());
  gait.walk(false); // before anything began
  for (int n = 0; n < 100; ++n) {
    gait.next(feet);
    CHECK(feet[0].heel_n + feet[1].heel_n == 0);
  }
  gait.walk(true);
  gait.next(feet);
  CHECK(feet[0].heel_landing > 0);
  CHECK(feet[1].heel_landing == 0);
  gait.walk(true); // is nothing new
  gait.reset();
  CHECK(gait.walking());
  gait.next(feet);
  CHECK(feet[0].heel_landing > 0);
  CHECK(feet[1].heel_n == 0);
  gait.walk(false);
  gait.reset();
  gait.step(1);
  gait.step(7); // there is none
  gait.next(feet);
  CHECK(feet[1].heel_landing > 0);
  CHECK(feet[0].heel_landing == 0);
  for (int n = 0; n < 2000; ++n)
    gait.next(feet);
  gait.step(1); // on the ground: it lands once more
  gait.next(feet);
  CHECK(feet[1].heel_landing > 0);
}

TEST_CASE("landings of one foot that overlap add up, four at most, and all end") {
  Gait one, many;
  for (Gait* gait : {&one, &many}) {
    gait->prepare(8000);
    gait->set({1.4, 700, 0}, 0);
    gait->step(0);
  }
  std::array<SoleState, Gait::kFeet> alone{}, feet{};
  std::vector<std::array<double, 4>> single;
  for (int n = 0; n < 8000; ++n) {
    one.next(alone);
    single.push_back({alone[0].heel_n, alone[0].ball_n, alone[0].heel_slope, alone[0].ball_slope});
  }
  const auto at = [&](int n, std::size_t what) {
    return n < 0 ? 0 : single[static_cast<std::size_t>(n)][what];
  };
  int ended = 0;
  for (int n = 0; n < 8000; ++n) {
    for (const int again : {400, 1000, 1700, 2400}) // the last ends the first
      if (n == again)
        many.step(0);
    many.next(feet);
    ended += feet[0].toe_off;
    std::array<double, 4> sum{};
    for (std::size_t i = 0; i < 4; ++i)
      sum[i] = (n < 2400 ? at(n, i) : 0) + at(n - 400, i) + at(n - 1000, i) + at(n - 1700, i) +
               at(n - 2400, i);
    CHECK(feet[0].heel_n == doctest::Approx(sum[0]));
    CHECK(feet[0].ball_n == doctest::Approx(sum[1]));
    CHECK(feet[0].heel_slope == doctest::Approx(sum[2]).epsilon(1e-6));
    CHECK(feet[0].ball_slope == doctest::Approx(sum[3]).epsilon(1e-6));
    CHECK(feet[1].heel_n == 0);
  }
  CHECK(ended == 4);
}

TEST_CASE("however unsteady a gait, the next contact waits a fifth of half a stride at least") {
  Gait gait;
  gait.prepare(8000);
  gait.set({1.4, 700, 0}, .5);
  gait.walk(true);
  GroundReaction reaction;
  reaction.set({1.4, 700, 0});
  std::array<SoleState, Gait::kFeet> feet{};
  // A contact is seen as a landing, also of a foot that is on the ground still and begins anew.
  double last = -1, shortest = 1e9, longest = 0;
  for (int n = 0; n < 8000 * 600; ++n) {
    gait.next(feet);
    if (feet[0].heel_landing == 0 && feet[1].heel_landing == 0)
      continue;
    if (last >= 0) {
      shortest = std::min(shortest, n / 8000. - last);
      longest = std::max(longest, n / 8000. - last);
    }
    last = n / 8000.;
  }
  const double half = reaction.stride_s() / 2;
  CHECK(shortest == doctest::Approx(.2 * half).epsilon(.01)); // of a thousand some 5 % are
  CHECK(longest > 1.8 * half);
}

TEST_CASE("forces of walking between the published speeds, and of running, follow their rules") {
  GroundReaction reaction;
  const auto highest = [&](double from, double to) {
    double best = 0;
    for (int i = 0; i <= 1000; ++i)
      best = std::max(best, reaction.force(from + (to - from) * i / 1000));
    return best;
  };
  const auto mean = [&] {
    double sum = 0;
    for (int i = 0; i < 20000; ++i)
      sum += reaction.force((i + .5) / 20000) / 20000;
    return sum;
  };
  reaction.set({1.25, 1000, 0}); // halfway between 1.1 and 1.4
  CHECK(highest(.1, .4) == doctest::Approx(1000 * .5 * (1.06 + 1.13)).epsilon(1e-4));
  CHECK(highest(.6, .9) == doctest::Approx(1000 * .5 * (1.06 + 1.10)).epsilon(1e-4));
  CHECK(reaction.force(.48) == doctest::Approx(1000 * .5 * (.8 + .72)).epsilon(1e-4));
  CHECK(reaction.duty() == doctest::Approx(.63));
  CHECK(reaction.stride_s() == doctest::Approx(120 / (100 + 27.8 * .25)));
  CHECK(mean() == doctest::Approx(1000 / (2 * .63)).epsilon(1e-3));
  const auto like = [&](const Walker& one, const Walker& two) {
    GroundReaction a, b;
    a.set(one);
    b.set(two);
    bool same = a.stance_s() == b.stance_s() && a.stride_s() == b.stride_s();
    for (int i = 0; i <= 50; ++i)
      same = same && a.force(i / 50.) == b.force(i / 50.);
    return same;
  };
  CHECK(like({9, 700, 0}, {2.5, 700, 0}));
  CHECK_FALSE(like({2.4, 700, 0}, {2.5, 700, 0}));
  CHECK(like({.1, 700, 0}, {.3, 700, 0}));
  CHECK(like({20, 700, 0, Style::kRun}, {8, 700, 0, Style::kRun}));
  CHECK(like({1, 700, 0, Style::kRun}, {1.5, 700, 0, Style::kRun}));
  CHECK(like({1, -5, 0}, {1, 0, 0}));
  CHECK(like({1, 1e9, 0}, {1, 1e5, 0}));
  CHECK(like({1, 700, 3}, {1, 700, 1}));
  CHECK_FALSE(like({1, 700, .9}, {1, 700, 1}));
  CHECK(like({1, 700, -3}, {1, 700, 0}));
  for (const double speed : {2., 4., 7.5}) {
    reaction.set({speed, 1000, 0, Style::kRun});
    const double stance = std::max(.32 - .02 * speed, .16), stride = 120 / (150 + 8 * speed);
    CHECK(reaction.stance_s() == doctest::Approx(std::min(stance, .29)));
    CHECK(reaction.stride_s() == doctest::Approx(stride));
    CHECK(mean() == doctest::Approx(1000 * stride / (2 * reaction.stance_s())).epsilon(1e-3));
    // What landings add (docs/footstep.md): m v / g of the heel, 5.3 % of the body, and of the
    // ball, 1.45 %, at 0.6 + 0.15 v and 0.6 of that; from 6 m/s the ball comes first, 1.7 %, and a
    // fifth.
    const double v = .6 + .15 * speed;
    const double landings = (speed < 6 ? .053 * v + .0145 * .6 * v : .017 * v + .0145 * .2 * v) /
                            (9.81 * reaction.stance_s()) * 1000;
    const double sine = (mean() - landings) * kPi / 2;
    CHECK(reaction.force(.5) == doctest::Approx(sine).epsilon(1e-3));
    CHECK(reaction.force(.75) == doctest::Approx(sine * std::sqrt(.5)).epsilon(1e-3));
  }
  GroundReaction bare; // the transient alone: .6 weights, 16.5 ms after contact
  bare.set({1.4, 1000, 0});
  reaction.set({1.4, 1000, 1});
  const double x = .0165 / reaction.stance_s();
  CHECK(reaction.force(x) - bare.force(x) == doctest::Approx(600).epsilon(.07)); // less: the flank
  CHECK(mean() == doctest::Approx(1000 / (2 * .62)).epsilon(1e-3)); // the impulse stays
  CHECK(reaction.force(0) == 0);
  CHECK(reaction.force(1) == 0);
}

TEST_CASE(
    "a region lands when it rises above noise, is told by 2.2 or 3.5 ms, and lifts at 2.5 %") {
  // 700 N. So slowly that it might be drift: 5 % = 35 N. On a line of 100 N/s the baseline follows,
  // 35 = 50 (1 - e^(-t/.5)), and waits from then on; the low-pass lags by sqrt(2)/(2 pi 200) =
  // 1.1 ms.
  const Line none{{{0, 0}}};
  Sensed sensed = sense({{{.2, 0}, {1.2, 100}, {2, 100}, {2.5, 0}}}, none, 3);
  REQUIRE(sensed.heel_landing_s.size() == 1);
  const double time = -.5 * std::log(1 - 35. / 50), baseline = 100 * time - 35;
  CHECK(sensed.heel_landing_s[0] == doctest::Approx(.2 + time + .0011).epsilon(.001));
  CHECK(sensed.heel_speed[0] < .1);
  REQUIRE(sensed.heel_up_s.size() == 1);
  CHECK(sensed.heel_up_s[0] ==
        doctest::Approx(2.5 - (baseline + 17.5) / 200 + .0011).epsilon(.001));
  CHECK(sensed.toe_off_s == sensed.heel_up_s);
  // As a step: 7000 N/s, firm by 2.2 ms.
  sensed = sense({{{.2, 0}, {.3, 700}, {.6, 700}, {.7, 0}}}, none, 1);
  REQUIRE(sensed.heel_landing_s.size() == 1);
  CHECK(std::abs(sensed.heel_landing_s[0] - (.2 + 1.05 / 7000 + .0011 + .0035)) < .0006);
  CHECK(sensed.heel_speed[0] == doctest::Approx(.5 * std::pow(10 / 26., 2 / 3.)).epsilon(.1));
}

TEST_CASE("a light touch is a landing and ends below half its threshold, or after half a second") {
  const Line none{{{0, 0}}};
  // 4 N for 0.15 s: never 5 %.
  Sensed sensed = sense(none, {{{.2, 0}, {.21, 4}, {.35, 4}, {.36, 0}}}, 1);
  REQUIRE(sensed.ball_landing_s.size() == 1);
  REQUIRE(sensed.toe_off_s.size() == 1);
  CHECK(sensed.ball_landing_s[0] - .2 < .0075);
  CHECK(sensed.toe_off_s[0] == doctest::Approx(.36).epsilon(.01));
  sensed = sense(none, {{{.2, 0}, {.21, 4}, {3, 4}}}, 3); // a lace that presses
  CHECK(sensed.ball_landing_s.size() == 1);
  REQUIRE(sensed.toe_off_s.size() == 1);
  CHECK(sensed.toe_off_s[0] == doctest::Approx(sensed.ball_landing_s[0] + .5).epsilon(.01));
}

TEST_CASE("no stance ends before 80 ms and no swing before 60 ms") {
  const Line none{{{0, 0}}};
  Sensed sensed = sense({{{.2, 0}, {.21, 400}, {.23, 400}, {.24, 0}}}, none, 1);
  REQUIRE(sensed.heel_up_s.size() == 1);
  CHECK(sensed.heel_up_s[0] == doctest::Approx(.2025 + .08).epsilon(.01));
  sensed = sense(
      {{{.2, 0}, {.21, 400}, {.40, 400}, {.41, 0}, {.43, 0}, {.44, 400}, {.7, 400}, {.71, 0}}},
      none, 1);
  REQUIRE(sensed.heel_landing_s.size() == 2);
  CHECK(sensed.heel_landing_s[1] == doctest::Approx(.4095 + .0011 + .06).epsilon(.01));
  CHECK(sensed.heel_up_s.size() == 2);
}

TEST_CASE("a ball lands under a heel that stands as soon as it rises") {
  const Line heel{{{.2, 0}, {.25, 500}, {.6, 500}, {.65, 0}}};
  const Line ball{{{.3, 0}, {1.0, 210}, {1.1, 0}}}; // 300 N/s: 1.05 N after 3.5 ms
  const Sensed sensed = sense(heel, ball, 2);
  REQUIRE(sensed.ball_landing_s.size() == 1);
  CHECK(sensed.ball_landing_s[0] == doctest::Approx(.3 + 1.05 / 300 + .0022 + .0011).epsilon(.005));
  CHECK(sensed.ball_speed[0] ==
        doctest::Approx(.3 * std::pow(300. / 700 / 3.3, 2 / 3.)).epsilon(.1));
  REQUIRE(sensed.heel_up_s.size() == 1);
  REQUIRE(sensed.toe_off_s.size() == 1); // the ball, last
  CHECK(sensed.toe_off_s[0] > 1.08);
}

TEST_CASE("a baseline follows in the air, within half a second upwards and at once downwards") {
  SoleSensor sensor;
  sensor.prepare(kRate);
  const auto settle = [&](double reading, double seconds) {
    SoleState sole;
    for (int n = 0; n < seconds * kRate; ++n)
      sole = sensor.next(reading, 0);
    return sole.heel_n;
  };
  // From 10 N: force 10 e^(-t/.5), apart from the time in which nothing may follow.
  const double first = settle(10, .2), second = settle(10, .5);
  CHECK(second / first == doctest::Approx(std::exp(-1.)).epsilon(.01));
  CHECK(settle(10, 5) < .01);
  CHECK(settle(-5, .3) < .01);
  CHECK(settle(0, .0) < 6);
  const double again = settle(0, .01);
  CHECK(again == doctest::Approx(5).epsilon(.1)); // the baseline had gone down to -5
  // And no lower than 2 % of the weight, 14 N: from -100 back to 0 N reads 14 at most.
  settle(-100, 2);
  CHECK(settle(0, .01) == doctest::Approx(14).epsilon(.1));
}

TEST_CASE("sensors, rooms and drives respond after a reset as when new") {
  SoleSensor used, fresh;
  Room used_room, fresh_room;
  Drive used_drive, fresh_drive;
  for (SoleSensor* sensor : {&used, &fresh})
    sensor->prepare(kRate);
  for (Room* room : {&used_room, &fresh_room}) {
    room->prepare(kRate);
    room->set({-3, .4, 3000});
  }
  for (Drive* drive : {&used_drive, &fresh_drive}) {
    drive->prepare(kRate);
    drive->set({1, 3, .3, .01, .2});
    const std::array<double, 4> table{100, 6, 300, -4};
    CHECK(drive->equalise(table));
  }
  const auto force = [](int n) { return 300 + 300 * std::sin(.001 * n); };
  for (int n = 0; n < 20011; ++n) {
    used.next(force(n), 20);
    used_room.next(std::sin(.3 * n));
    used_drive.next(30 * std::sin(.02 * n), 9 * std::cos(.02 * n), 0, 5);
  }
  CHECK_FALSE(used_room.silent());
  used.reset();
  used_room.reset();
  used_drive.reset();
  CHECK(used_room.silent());
  CHECK_FALSE(used.in_stance());
  bool same = true;
  for (int n = 0; n < 20011; ++n) {
    const SoleState a = used.next(force(n), 200), b = fresh.next(force(n), 200);
    same = same && std::abs(a.heel_n - b.heel_n) < 1e-9 && a.heel_landing == b.heel_landing &&
           std::abs(a.heel_slope - b.heel_slope) < 1e-6 && a.toe_off == b.toe_off;
    const double x = n < 4000 ? std::sin(.3 * n) : 0;
    same = same && std::abs(used_room.next(x) - fresh_room.next(x)) < 1e-12;
    const Drive::Pair c = used_drive.next(x, -x, 0, 0), d = fresh_drive.next(x, -x, 0, 0);
    same = same && std::abs(c.heel - d.heel) < 1e-12 && std::abs(c.ball - d.ball) < 1e-12;
  }
  CHECK(same);
}

TEST_CASE("a limiter acts at once and releases within 50 ms") {
  PeakLimit limit;
  limit.prepare(kRate);
  CHECK(limit.next(.5, 1) == .5);
  CHECK(limit.next(4, 1) == doctest::Approx(1));
  // The gain fell to 1/4 and rises by 1 - e^(-t/50 ms) of what is missing.
  for (const double passed : {.02, .05}) {
    limit.reset();
    limit.next(4, 1);
    double y = 0;
    for (int n = 0; n < passed * kRate; ++n)
      y = limit.next(.1, 1);
    CHECK(y == doctest::Approx(.1 * (1 - .75 * std::exp(-passed / .05))).epsilon(1e-3));
  }
  CHECK(limit.next(-9, 1) == doctest::Approx(-1));
  limit.reset();
  CHECK(limit.next(1, 1) == 1);
}

TEST_CASE("a calibration reads 5 to 32 points, beyond its ends too, until it is cleared") {
  Calibration table;
  std::vector<double> points;
  for (int i = 0; i < 33; ++i) {
    points.push_back(i);
    points.push_back(i * i);
  }
  CHECK_FALSE(table.set(points));
  points.resize(64);
  CHECK(table.set(points));
  CHECK(table.force(30.5) == doctest::Approx(.5 * (900 + 961)));
  CHECK(table.force(32) == doctest::Approx(961 + 61));
  CHECK(table.force(-1) == doctest::Approx(-1));
  CHECK(table.force(1) == doctest::Approx(1));
  points.push_back(99);
  CHECK_FALSE(table.set(points)); // half a point
  points = {0, 0, 1, 1, 2, 2, 3, 3, 3, 4};
  CHECK_FALSE(table.set(points)); // a reading twice
  points = {0, 0, 1, 1, 2, 2, 3, 3, 4, 3};
  CHECK_FALSE(table.set(points)); // a force twice
  points = {0, 0, 1, 1, 2, 2, 3, 3, 4, std::nan("")};
  CHECK_FALSE(table.set(points));
  CHECK(table.force(32) == doctest::Approx(961 + 61));
  table.clear();
  CHECK(table.force(32) == 32);
}

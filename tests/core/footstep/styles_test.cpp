#include "core/footstep/gait.hpp"
#include "core/footstep/ground_reaction.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

// Ways of walking against momentum and published numbers (docs/theory/footstep.md).

using namespace tactus::footstep;

namespace {

constexpr std::array kStylesToTest{Style::kWalk, Style::kRun, Style::kSneak, Style::kUpstairs,
                                   Style::kDownstairs};

GroundReaction reaction_of(Style style, double speed, double shoe = 0, double weight = 700) {
  GroundReaction reaction;
  reaction.set({speed, weight, shoe, style});
  return reaction;
}

double mean_of(const GroundReaction& reaction) {
  double sum = 0;
  for (int i = 0; i < 5000; ++i)
    sum += reaction.force((i + 0.5) / 5000) / 5000;
  return sum;
}

struct Extreme {
  double force, at;
};
/// The highest force between two times, or the lowest.
Extreme extreme(const GroundReaction& reaction, double from, double to, double sign = 1) {
  Extreme best{-1e9 * sign, 0};
  for (double x = from; x < to; x += 5e-4)
    if (sign * reaction.force(x) > sign * best.force)
      best = {reaction.force(x), x};
  return best;
}
double highest(const GroundReaction& reaction, double from, double to) {
  return extreme(reaction, from, to).force;
}

} // namespace

TEST_CASE("a track passes through its values, without a step, and its integral is exact") {
  Track track(2);
  track.to(5, 0.3, 0.4, 1.5).hold(0.1).to(-1, 0.2, 1).to(3, 0.25).to(0, 0); // the last is none
  CHECK(track.duration_s() == doctest::Approx(0.85));
  CHECK(track.at(-1) == 2);
  CHECK(track.at(0.35) == 5);
  CHECK(track.at(0.4 + 0.2) == doctest::Approx(-1));
  CHECK(track.at(9) == 3);
  CHECK(track.at(0.6 + 0.125) == doctest::Approx(1)); // half a cosine's middle
  double sum = 0, step = 0, last = 2;
  const int count = 85000;
  for (int i = 0; i < count; ++i) {
    const double value = track.at((i + 0.5) * 0.85 / count);
    sum += value * 0.85 / count;
    step = std::max(step, std::abs(value - last));
    last = value;
  }
  CHECK(sum == doctest::Approx(track.integral()).epsilon(1e-6));
  CHECK(step < 1e-2);
  CHECK(track.scaled(3, 2).integral() == doctest::Approx(6 * track.integral()));
  CHECK(track.scaled(3, 2).at(1.2) == doctest::Approx(3 * track.at(0.6)));
  Track first(2);
  first.to(5, 0.3, 0.4, 1.5).append(Track(5).hold(0.1).to(-1, 0.2, 1));
  for (double t = 0; t < 0.6; t += 0.01)
    CHECK(first.at(t) == doctest::Approx(track.at(t)));
}

TEST_CASE("the walking force has the published peaks and valley at their times") {
  const double table[4][7] = {{0.8, 1.02, 0.24, 0.86, 0.48, 1.02, 0.76},
                              {1.1, 1.06, 0.23, 0.80, 0.48, 1.06, 0.76},
                              {1.4, 1.13, 0.22, 0.72, 0.48, 1.10, 0.77},
                              {1.8, 1.30, 0.20, 0.58, 0.46, 1.17, 0.78}};
  for (const double shoe : {0.0, 1.0})
    for (const auto& row : table) {
      const GroundReaction walk = reaction_of(Style::kWalk, row[0], shoe);
      const Extreme first = extreme(walk, 0.1, 0.4), valley = extreme(walk, 0.3, 0.6, -1),
                    second = extreme(walk, 0.6, 0.95);
      CHECK(first.force / 700 == doctest::Approx(row[1]).epsilon(0.02));
      CHECK(std::abs(first.at - row[2]) < 0.015);
      CHECK(valley.force / 700 == doctest::Approx(row[3]).epsilon(0.02));
      CHECK(std::abs(valley.at - row[4]) < 0.015);
      CHECK(second.force / 700 == doctest::Approx(row[5]).epsilon(0.02));
      CHECK(std::abs(second.at - row[6]) < 0.015);
    }
}

TEST_CASE("each foot of a steady walker carries half of the impulse, whatever the way of walking") {
  for (const Style style : kStylesToTest)
    for (const double shoe : {0.0, 0.5, 1.0})
      for (const double speed : {0.3, 0.6, 0.9, 1.2, 1.4, 1.7, 2.1, 2.5, 4.0, 6.0, 8.0}) {
        const GroundReaction reaction = reaction_of(style, speed, shoe);
        CAPTURE(static_cast<int>(style));
        CAPTURE(speed);
        CHECK(mean_of(reaction) == doctest::Approx(700 / (2 * reaction.duty())).epsilon(5e-4));
        double min_force = 0;
        for (double x = 0; x <= 1; x += 1e-3)
          min_force = std::min(min_force, reaction.force(x));
        CHECK(min_force == 0);
      }
}

TEST_CASE("forces of walking between the published speeds, and of running, follow their rules") {
  GroundReaction reaction;
  reaction.set({1.25, 1000, 0}); // halfway between 1.1 and 1.4
  CHECK(highest(reaction, .1, .4) == doctest::Approx(1000 * .5 * (1.06 + 1.13)).epsilon(1e-4));
  CHECK(highest(reaction, .6, .9) == doctest::Approx(1000 * .5 * (1.06 + 1.10)).epsilon(1e-4));
  CHECK(reaction.force(.48) == doctest::Approx(1000 * .5 * (.8 + .72)).epsilon(1e-4));
  CHECK(reaction.duty() == doctest::Approx(.63));
  CHECK(reaction.stride_s() == doctest::Approx(120 / (100 + 27.8 * .25)));
  CHECK(mean_of(reaction) == doctest::Approx(1000 / (2 * .63)).epsilon(1e-3));
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
    CHECK(mean_of(reaction) ==
          doctest::Approx(1000 * stride / (2 * reaction.stance_s())).epsilon(1e-3));
    // What landings add (docs/theory/footstep.md): m v / g of the heel, 5.3 % of the body, and of
    // the ball, 1.45 %, at 0.6 + 0.15 v and 0.6 of that; from 6 m/s the ball comes first, 1.7 %,
    // and a fifth.
    const double v = .6 + .15 * speed;
    const double landings = (speed < 6 ? .053 * v + .0145 * .6 * v : .017 * v + .0145 * .2 * v) /
                            (9.81 * reaction.stance_s()) * 1000;
    const double sine = (mean_of(reaction) - landings) * std::numbers::pi / 2;
    CHECK(reaction.force(.5) == doctest::Approx(sine).epsilon(1e-3));
    CHECK(reaction.force(.75) == doctest::Approx(sine * std::sqrt(.5)).epsilon(1e-3));
  }
  GroundReaction bare; // the transient alone: .6 weights, 16.5 ms after contact
  bare.set({1.4, 1000, 0});
  reaction.set({1.4, 1000, 1});
  const double x = .0165 / reaction.stance_s();
  CHECK(reaction.force(x) - bare.force(x) == doctest::Approx(600).epsilon(.07)); // less: the flank
  CHECK(mean_of(reaction) == doctest::Approx(1000 / (2 * .62)).epsilon(1e-3)); // the impulse stays
  CHECK(reaction.heel_share(0.46) == doctest::Approx(0.5).epsilon(0.01));      // heel to ball
  CHECK(reaction.heel_share(0) == 1);
  CHECK(reaction.heel_share(0.11) == 1); // the ball has not landed
  CHECK(reaction.heel_share(0.7) == 0);  // the heel is up
  CHECK(reaction.force(0) == 0);
  CHECK(reaction.force(1) == 0);
}

TEST_CASE("a sneaking walker lands softly, without a heel's transient, long on both feet") {
  for (const double speed : {0.5, 1.0, 1.4, 2.5}) {
    const GroundReaction sneak = reaction_of(Style::kSneak, speed, 1),
                         walk = reaction_of(Style::kWalk, speed, 1);
    CHECK(sneak.heel().speed_m_per_s < 0.15);
    CHECK(sneak.heel().speed_m_per_s < 0.5 * walk.heel().speed_m_per_s);
    CHECK(sneak.ball().speed_m_per_s < sneak.heel().speed_m_per_s);
    CHECK(sneak.duty() > walk.duty());
    CHECK(sneak.duty() > 0.65);
    CHECK(sneak.stride_s() > walk.stride_s());
    CHECK(highest(sneak, 0, 1) < 1.01 * 700); // no peaks
    CHECK(highest(sneak, 0, 0.05) < 0.1 * highest(walk, 0, 0.05));
    for (double x = 0; x < 1; x += 0.01) // the shoe's hardness does nothing to the force
      CHECK(sneak.force(x) == reaction_of(Style::kSneak, speed, 0).force(x));
  }
}

TEST_CASE("on stairs the ball comes first; down the first peak is the larger, up the second") {
  const GroundReaction up = reaction_of(Style::kUpstairs, 1.4),
                       down = reaction_of(Style::kDownstairs, 1.4);
  for (const GroundReaction* stairs : {&up, &down}) {
    CHECK(stairs->ball_first());
    CHECK(stairs->ball().at == 0);
    CHECK(stairs->heel_share(0.05) == 0);
    CHECK(stairs->heel_share(0.4) > 0.3);
    CHECK(stairs->heel_share(0.8) == 0);
    CHECK(stairs->duty() > 0.6);
    CHECK(stairs->duty() <= 0.7); // Beaulieu et al. 2008: 65:35 to 70:30 down
  }
  const double down_first = highest(down, 0.05, 0.4), down_second = highest(down, 0.6, 0.95),
               up_first = highest(up, 0.05, 0.4), up_second = highest(up, 0.6, 0.95);
  CHECK(down_first / 700 > 1.4);
  CHECK(down_first / 700 < 1.6); // Stacoff et al. 2005
  CHECK(down_second < 0.7 * down_first);
  CHECK(up_second > 1.1 * up_first);
  CHECK(up_second / 700 > 1.1);
  CHECK(up_second / 700 < 1.3);
  CHECK(down.ball().speed_m_per_s > 2 * up.ball().speed_m_per_s);
  CHECK(up.stride_s() > reaction_of(Style::kWalk, 1.4).stride_s()); // people slow down
  CHECK(up.stride_s() > down.stride_s());
}

TEST_CASE("forces grow over speed as published: walking from 1.2, running to 2.5 body weights") {
  // Keller et al. 1996: a line from 1.2 at 1.5 m/s to 2.5 at 6 m/s; slow jogging 50 % above it.
  CHECK(highest(reaction_of(Style::kWalk, 1.5), 0.1, 0.4) / 700 ==
        doctest::Approx(1.2).epsilon(0.05));
  for (const double speed : {4.0, 5.0, 6.0}) {
    const double keller = 1.2 + 1.3 * (speed - 1.5) / 4.5;
    CHECK(highest(reaction_of(Style::kRun, speed), 0.2, 0.8) / 700 ==
          doctest::Approx(keller).epsilon(0.2));
  }
  CHECK(highest(reaction_of(Style::kRun, 6), 0.2, 0.8) / 700 == doctest::Approx(2.5).epsilon(0.06));
  const double jog = highest(reaction_of(Style::kRun, 2), 0.2, 0.8) / 700;
  CHECK(jog / (1.2 + 1.3 * 0.5 / 4.5) > 1.4);
  CHECK(jog / (1.2 + 1.3 * 0.5 / 4.5) < 1.7);
  // And loading rates, peak over the time to it, from 8 to 30 body weights a second.
  const auto rate = [](Style style, double speed) {
    const GroundReaction reaction = reaction_of(style, speed);
    const Extreme peak = extreme(reaction, 0.1, 0.6);
    return peak.force / 700 / (peak.at * reaction.stance_s());
  };
  CHECK(rate(Style::kWalk, 1.5) == doctest::Approx(8).epsilon(0.1));
  for (const double speed : {3.0, 4.5, 6.0})
    CHECK(rate(Style::kRun, speed) == doctest::Approx(8 + 22 * (speed - 1.5) / 4.5).epsilon(0.25));
}

TEST_CASE("feet land as fast as published: by energy, above the body's fall, growing over speed") {
  // Chi & Schmitt 2005: 0.24 to 3.99 J behind a heel that strikes, walking to running.
  const double mass = 70;
  double last = 0;
  const auto energy = [&](const Landing& heel) {
    return 0.5 * heel.mass * mass * heel.speed_m_per_s * heel.speed_m_per_s;
  };
  for (double speed = 0.3; speed <= 2.5; speed += 0.1) {
    const Landing heel = reaction_of(Style::kWalk, speed).heel();
    CHECK(heel.speed_m_per_s > last);
    last = heel.speed_m_per_s;
    if (speed > 0.8) {
      CHECK(energy(heel) > 0.24);
      CHECK(energy(heel) < 3.99);
    }
  }
  for (double speed = 1.5; speed < 8; speed += 0.25) {
    const GroundReaction run = reaction_of(Style::kRun, speed);
    const Landing& first = run.ball_first() ? run.ball() : run.heel();
    CHECK(first.speed_m_per_s >= 0.8);
    CHECK(first.speed_m_per_s <= 1.8);
    CHECK(first.speed_m_per_s > kGravity * run.flight_s() / 2); // the body falls that fast alone
    CHECK(run.ball_first() == (speed >= 6));
    if (!run.ball_first() && speed < 5.5)
      CHECK(energy(first) < 3.99);
  }
  // At the change from walking to running, 2 m/s: less than 4 dB.
  const double ratio = reaction_of(Style::kRun, 2).heel().speed_m_per_s /
                       reaction_of(Style::kWalk, 2).heel().speed_m_per_s;
  CHECK(ratio > 1);
  CHECK(ratio < 1.5);
}

TEST_CASE("weight makes forces larger and no landing faster") {
  for (const Style style : kStylesToTest) {
    const GroundReaction light = reaction_of(style, 1.4, 0.3, 300),
                         heavy = reaction_of(style, 1.4, 0.3, 1200);
    CHECK(light.heel().speed_m_per_s == heavy.heel().speed_m_per_s);
    CHECK(light.ball().speed_m_per_s == heavy.ball().speed_m_per_s);
    for (double x = 0; x < 1; x += 0.01)
      CHECK(heavy.force(x) == doctest::Approx(4 * light.force(x)));
  }
}

TEST_CASE("a first landing has the impulse of its mass, and slides 3 mm before it holds") {
  for (const Style style : kStylesToTest) {
    Gait gait;
    gait.prepare(48000);
    gait.set({1.4, 700, 0, style}, 0);
    gait.step(0);
    std::array<SoleState, 2> feet{};
    double slid = 0, impulse = 0;
    const GroundReaction reaction = reaction_of(style, 1.4);
    const Landing& first = reaction.ball_first() ? reaction.ball() : reaction.heel();
    const int count = static_cast<int>(Landing::kImpactTime * 48000);
    for (int n = 0; n < count; ++n) {
      gait.next(feet);
      slid += (feet[0].heel_slip + feet[0].ball_slip) / 48000;
      const double x = (n + 1) / 48000.0 / reaction.stance_s();
      impulse += (feet[0].heel_n + feet[0].ball_n - 700 * reaction.load().at(x)) / 48000;
    }
    if (style != Style::kRun) // its ball lands within the heel's impact
      CHECK(impulse ==
            doctest::Approx(first.mass * 700 / kGravity * first.speed_m_per_s).epsilon(0.01));
    CHECK(slid > 0.002);
    CHECK(slid < 0.005);
    slid = 0;
    for (int n = 0; n < 48000; ++n) {
      gait.next(feet);
      slid += feet[0].heel_slip + feet[0].ball_slip;
    }
    CHECK(slid == 0);
  }
}

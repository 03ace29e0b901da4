#include "core/footstep/gait.hpp"
#include "core/footstep/ground_reaction.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

using namespace tactus::footstep;

namespace {

GroundReaction reaction(double speed, bool run = false, double shoe = 0, double weight = 700) {
  GroundReaction made;
  made.set({speed, weight, shoe, run ? Style::kRun : Style::kWalk});
  return made;
}

double mean(const GroundReaction& of) {
  const int count = 20000;
  double sum = 0;
  for (int i = 0; i < count; ++i)
    sum += of.force((i + 0.5) / count);
  return sum / count;
}

struct Extreme {
  double force, at;
};

Extreme extreme(const GroundReaction& of, double from, double to, double sign) {
  Extreme best{-1e9 * sign, 0};
  for (double x = from; x < to; x += 1e-4)
    if (sign * of.force(x) > sign * best.force)
      best = {of.force(x), x};
  return best;
}

} // namespace

TEST_CASE("the walking force has the published peaks and valley at their times") {
  const double table[4][7] = {{0.8, 1.02, 0.24, 0.86, 0.48, 1.02, 0.76},
                              {1.1, 1.06, 0.23, 0.80, 0.48, 1.06, 0.76},
                              {1.4, 1.13, 0.22, 0.72, 0.48, 1.10, 0.77},
                              {1.8, 1.30, 0.20, 0.58, 0.46, 1.17, 0.78}};
  for (const double shoe : {0.0, 1.0})
    for (const auto& row : table) {
      const GroundReaction walk = reaction(row[0], false, shoe);
      const Extreme first = extreme(walk, 0.1, 0.4, 1), valley = extreme(walk, 0.3, 0.6, -1),
                    second = extreme(walk, 0.6, 0.95, 1);
      CHECK(first.force / 700 == doctest::Approx(row[1]).epsilon(0.02));
      CHECK(std::abs(first.at - row[2]) < 0.015);
      CHECK(valley.force / 700 == doctest::Approx(row[3]).epsilon(0.02));
      CHECK(std::abs(valley.at - row[4]) < 0.015);
      CHECK(second.force / 700 == doctest::Approx(row[5]).epsilon(0.02));
      CHECK(std::abs(second.at - row[6]) < 0.015);
    }
}

TEST_CASE(
    "steady walking and running carry the weight: the mean over a stance is weight / 2 duty") {
  for (const double shoe : {0.0, 0.5, 1.0})
    for (double speed = 0.4; speed < 2.5; speed += 0.1) {
      const GroundReaction walk = reaction(speed, false, shoe);
      CHECK(mean(walk) == doctest::Approx(700 / (2 * walk.duty())).epsilon(0.01));
      const GroundReaction run = reaction(2 * speed + 1, true, shoe);
      CHECK(mean(run) == doctest::Approx(700 / (2 * run.duty())).epsilon(0.01));
    }
}

TEST_CASE("walkers have both feet down for a while, runners never") {
  for (double speed = 0.5; speed < 2.5; speed += 0.25)
    CHECK(reaction(speed).duty() > 0.5);
  for (double speed = 2; speed < 6; speed += 0.5) {
    CHECK(reaction(speed, true).duty() < 0.5);
    CHECK(extreme(reaction(speed, true), 0.3, 0.7, 1).force / 700 > 1.9);
    CHECK(extreme(reaction(speed, true), 0.3, 0.7, 1).force / 700 < 3.0);
  }
}

TEST_CASE("twice the weight is twice the force, and a hard heel adds its transient early") {
  const GroundReaction one = reaction(1.4, false, 1), two = reaction(1.4, false, 1, 1400);
  for (double x = 0; x <= 1; x += 0.01)
    CHECK(two.force(x) == doctest::Approx(2 * one.force(x)));
  const GroundReaction soft = reaction(1.4);
  const double at = 0.0165 / one.stance_s();
  CHECK((one.force(at) - soft.force(at)) / 700 == doctest::Approx(0.6).epsilon(0.1));
}

TEST_CASE("heel and ball carry the whole, and change over at 46 % of the stance") {
  const GroundReaction walk = reaction(1.4);
  CHECK(walk.heel_share(0.46) == doctest::Approx(0.5).epsilon(0.01));
  CHECK(walk.heel_share(0) == 1);
  CHECK(walk.heel_share(0.11) == 1); // the ball has not landed
  CHECK(walk.heel_share(0.7) == 0);  // the heel is up
}

TEST_CASE("a gait puts down heel, ball, lifts the heel and the toes, step after step, both feet") {
  Gait gait;
  gait.prepare(48000);
  gait.set({1.4, 700, 0.5}, 0.04);
  gait.walk(true);
  std::array<SoleState, Gait::kFeet> feet{};
  std::array<std::vector<int>, 2> phases;
  std::array<double, 2> impulse{};
  double both = 0;
  std::vector<double> contacts;
  const double seconds = 120;
  for (int n = 0; n < static_cast<int>(seconds * 48000); ++n) {
    gait.next(feet);
    for (std::size_t i = 0; i < 2; ++i) {
      if (feet[i].heel_landing > 0) {
        phases[i].push_back(0);
        contacts.push_back(n / 48000.0);
        CHECK(feet[i].heel_landing < 2);
      }
      if (feet[i].ball_landing > 0)
        phases[i].push_back(1);
      if (feet[i].heel_up)
        phases[i].push_back(2);
      if (feet[i].toe_off)
        phases[i].push_back(3);
      impulse[i] += (feet[i].heel_n + feet[i].ball_n) / 48000;
    }
    both += feet[0].heel_n + feet[0].ball_n > 0 && feet[1].heel_n + feet[1].ball_n > 0;
  }
  for (const auto& foot : phases)
    for (std::size_t k = 0; k < foot.size(); ++k)
      REQUIRE(foot[k] == static_cast<int>(k % 4));
  // 111 steps a minute at 1.4 m/s; the scatter of 222 steps' mean is 0.3 %.
  CHECK(static_cast<double>(contacts.size()) / seconds * 60 ==
        doctest::Approx(111.1).epsilon(0.02));
  CHECK((impulse[0] + impulse[1]) / seconds == doctest::Approx(700).epsilon(0.03));
  // Both feet are down for 2 duty - 1 of the time.
  CHECK(both / (seconds * 48000) == doctest::Approx(0.24).epsilon(0.15));
  double sum = 0, square = 0;
  for (std::size_t k = 1; k < contacts.size(); ++k) {
    const double d = contacts[k] - contacts[k - 1];
    sum += d;
    square += d * d;
  }
  const auto steps = static_cast<double>(contacts.size() - 1);
  const double scatter = std::sqrt(square / steps - sum / steps * sum / steps) / (sum / steps);
  CHECK(scatter > 0.03);
  CHECK(scatter < 0.05);
}

TEST_CASE("gaits of the same seed are the same and of another seed are not") {
  Gait a, b, c;
  c.seed(9);
  std::array<SoleState, Gait::kFeet> x{}, y{}, z{};
  for (Gait* gait : {&a, &b, &c}) {
    gait->prepare(44100);
    gait->walk(true);
  }
  bool same = true, other = false;
  for (int n = 0; n < 200000; ++n) {
    a.next(x);
    b.next(y);
    c.next(z);
    same = same && x[0].heel_n == y[0].heel_n && x[1].ball_n == y[1].ball_n;
    other = other || x[0].heel_n != z[0].heel_n;
  }
  CHECK(same);
  CHECK(other);
}

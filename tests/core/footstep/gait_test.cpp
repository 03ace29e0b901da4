#include "tests/core/footstep/gait_recording.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

// A gait: the order of its events, their times, speeds and forces, and how they scatter.

using namespace tactus::footstep;

TEST_CASE("a gait without variation keeps the times and speeds of its walker") {
  for (const Walker& walker :
       {Walker{.9, 700, .2}, Walker{1.4, 700, .2}, Walker{3, 650, .2, Style::kRun}}) {
    CAPTURE(walker.speed_m_per_s);
    GroundReaction reaction;
    reaction.set(walker);
    const double stride = reaction.stride_s(), stance = reaction.stance_s();
    const bool run = walker.style == Style::kRun;
    const double v = walker.speed_m_per_s, heel = run ? .6 + .15 * v : .5 * std::pow(v / 1.4, .8);
    const Recording made = play(walker, 6, {kWalk});
    for (const int foot : {0, 1}) {
      const auto heels = made.of(Phase::kHeelDown, 0, foot),
                 balls = made.of(Phase::kBallDown, 0, foot), ups = made.of(Phase::kHeelUp, 0, foot),
                 offs = made.of(Phase::kToeOff, 0, foot);
      REQUIRE(offs.size() >= 4);
      for (std::size_t k = 0; k < 4; ++k) {
        const double begin = static_cast<double>(k) * stride + foot * stride / 2;
        CHECK(std::abs(heels[k].t - begin) < 3 / made.rate);
        CHECK(std::abs(balls[k].t - heels[k].t - (run ? .04 : .11) * stance) < 2 / made.rate);
        CHECK(std::abs(ups[k].t - heels[k].t - .62 * stance) < 2 / made.rate);
        CHECK(std::abs(offs[k].t - heels[k].t - stance) < 2 / made.rate);
        const double softer = k > 0 ? 1 : foot == 0 ? .75 : .9; // the first two
        CHECK(heels[k].speed == doctest::Approx(softer * heel));
        CHECK(balls[k].speed == doctest::Approx(softer * .6 * heel));
      }
    }
  }
  const auto landings = [](const Walker& walker, double variation = 0) {
    std::vector<double> numbers;
    for (const Event& e : play(walker, 4, {kWalk}, 8000, variation, false).of(Phase::kHeelDown))
      numbers.insert(numbers.end(), {e.t, e.speed});
    return numbers;
  };
  CHECK(landings({20, 700, 0, Style::kRun}) == landings({8, 700, 0, Style::kRun}));
  CHECK(landings({.1, 700, 0}) == landings({.3, 700, 0}));
  CHECK(landings({9, 700, 0}) == landings({2.5, 700, 0}));
  CHECK(landings({1.4, 700, 0}, 9) == landings({1.4, 700, 0}, .5));
}

TEST_CASE("step after step both feet put down heel and ball, lift heel and toes, and carry the "
          "weight, with the scatter of their variation") {
  constexpr double kSeconds = 150, kRate = 8000;
  Gait gait;
  gait.prepare(kRate);
  gait.set({1.4, 700, 0.4}, 0.04);
  gait.walk(true);
  std::array<SoleState, Gait::kFeet> feet{};
  std::array<std::size_t, 2> phases{};
  std::array<double, 2> impulse{};
  double carried = 0, both = 0, before = 0;
  std::vector<double> steps, impulses, speeds; // logarithms
  for (int n = 0; n < kSeconds * kRate; ++n) {
    gait.next(feet);
    bool all_down = true;
    for (std::size_t i = 0; i < 2; ++i) {
      const SoleState& sole = feet[i];
      const bool events[] = {sole.heel_landing > 0, sole.ball_landing > 0, sole.heel_up,
                             sole.toe_off};
      for (std::size_t phase = 0; phase < 4; ++phase)
        if (events[phase])
          REQUIRE(phases[i]++ % 4 == phase);
      if (sole.heel_landing > 0) {
        steps.push_back(std::log(n / kRate - std::exchange(before, n / kRate)));
        speeds.push_back(std::log(sole.heel_landing));
      }
      impulse[i] += (sole.heel_n + sole.ball_n) / kRate;
      carried += (sole.heel_n + sole.ball_n) / kRate;
      if (sole.toe_off)
        impulses.push_back(std::log(std::exchange(impulse[i], 0)));
      all_down = all_down && sole.heel_n + sole.ball_n > 0;
    }
    both += all_down;
  }
  const auto scatter = [](const std::vector<double>& x) { // but for the first steps
    double sum = 0, square = 0;
    for (std::size_t i = 3; i < x.size(); ++i) {
      sum += x[i] / static_cast<double>(x.size() - 3);
      square += x[i] * x[i] / static_cast<double>(x.size() - 3);
    }
    return std::sqrt(square - sum * sum);
  };
  // 111 steps a minute at 1.4 m/s; of 278 steps the mean time is known to 0.3 %, a scatter to 4.2
  // %.
  CHECK(static_cast<double>(steps.size()) / kSeconds * 60 == doctest::Approx(111.1).epsilon(0.02));
  CHECK(carried / kSeconds == doctest::Approx(700).epsilon(0.03));
  // Both feet are down for 2 duty - 1 of the time.
  CHECK(both / (kSeconds * kRate) == doctest::Approx(0.24).epsilon(0.15));
  CHECK(scatter(steps) == doctest::Approx(.04).epsilon(.18));
  CHECK(scatter(impulses) == doctest::Approx(.04 * std::sqrt(2.)).epsilon(.18)); // force and stance
  CHECK(scatter(speeds) == doctest::Approx(.16).epsilon(.18));
}

TEST_CASE("walking begins at once from the air; single steps are steps") {
  Gait gait;
  gait.prepare(8000);
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
  for (int n = 0; n < 400; ++n)
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
  for (int n = 0; n < 8000 * 150; ++n) {
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
  CHECK(shortest == doctest::Approx(.2 * half).epsilon(.01)); // some 5 % are
  CHECK(longest > 1.8 * half);
}

TEST_CASE("gaits of the same seed are the same and of another seed are not") {
  Gait a, b, c;
  c.seed(9);
  std::array<SoleState, Gait::kFeet> x{}, y{}, z{};
  for (Gait* gait : {&a, &b, &c}) {
    gait->prepare(8000);
    gait->walk(true);
  }
  bool same = true, other = false;
  for (int n = 0; n < 40000; ++n) {
    a.next(x);
    b.next(y);
    c.next(z);
    same = same && x[0].heel_n == y[0].heel_n && x[1].ball_n == y[1].ball_n;
    other = other || x[0].heel_n != z[0].heel_n;
  }
  CHECK(same);
  CHECK(other);
}

TEST_CASE("the two feet of a walker carry the weight on average, heel and ball the whole of it") {
  for (int i = 0; i < 5; ++i)
    for (const double speed : {0.7, 1.4, 3.0}) {
      const auto style = static_cast<Style>(i);
      Gait gait;
      gait.prepare(8000);
      gait.set({speed, 900, 0.5, style}, 0);
      gait.walk(true);
      GroundReaction reaction;
      reaction.set({speed, 900, 0.5, style});
      const int stride = static_cast<int>(std::lround(reaction.stride_s() * 8000));
      std::array<SoleState, 2> feet{};
      for (int n = 0; n < 4 * stride; ++n)
        gait.next(feet);
      double sum = 0, difference = 0, min_force = 0;
      for (int n = 0; n < 5 * stride; ++n) {
        gait.next(feet);
        for (const SoleState& sole : feet) {
          sum += sole.heel_n + sole.ball_n;
          min_force = std::min({min_force, sole.heel_n, sole.ball_n});
        }
        if (style == Style::kSneak)
          difference = std::max(difference, std::abs(feet[0].heel_n + feet[0].ball_n +
                                                     feet[1].heel_n + feet[1].ball_n - 900));
      }
      CAPTURE(static_cast<int>(style));
      CAPTURE(speed);
      CHECK(sum / (5.0 * stride) == doctest::Approx(900).epsilon(0.005));
      CHECK(min_force == 0);
      CHECK(difference < 0.03 * 900); // nobody rises or falls; landings of a foot are what is left
    }
}

#include "core/dsp/random.hpp"
#include "core/footstep/gait.hpp"
#include "core/footstep/sole_sensor.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

// A sole's sensors by their definition, on straight lines of force; and under walkers of every
// kind, through noise: each landing is found once, and in time.

using namespace tactus;
using namespace tactus::footstep;

namespace {

constexpr double kRate = 48000;

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

Sensed sense(const Line& heel, const Line& ball, double seconds) {
  SoleSensor sensor;
  sensor.prepare(kRate);
  sensor.set(700);
  Sensed sensed;
  for (int n = 0; n < seconds * kRate; ++n) {
    const double t = n / kRate;
    const SoleState sole = sensor.next(heel.at(t), ball.at(t));
    const auto note = [&](double speed, std::vector<double>& times, std::vector<double>& speeds) {
      if (speed > 0) {
        times.push_back(t);
        speeds.push_back(speed);
      }
    };
    note(sole.heel_landing, sensed.heel_landing_s, sensed.heel_speed);
    note(sole.ball_landing, sensed.ball_landing_s, sensed.ball_speed);
    if (sole.heel_up)
      sensed.heel_up_s.push_back(t);
    if (sole.toe_off)
      sensed.toe_off_s.push_back(t);
  }
  return sensed;
}

const Line kNone{{{0, 0}}};

} // namespace

TEST_CASE(
    "a region lands when it rises above noise, is told by 2.2 or 3.5 ms, and lifts at 2.5 %") {
  // 700 N. So slowly that it might be drift: 5 % = 35 N above the noise, of which the rise is taken
  // for part. It was load: the baseline is 0 again. The low-pass lags by sqrt(2)/(2 pi 200) =
  // 1.1 ms.
  Sensed sensed = sense({{{.2, 0}, {1.2, 100}, {2, 100}, {2.5, 0}}}, kNone, 3);
  REQUIRE(sensed.heel_landing_s.size() == 1);
  CHECK(sensed.heel_landing_s[0] > .2 + .35);
  CHECK(sensed.heel_landing_s[0] < .2 + .70);
  CHECK(sensed.heel_speed[0] < .1);
  REQUIRE(sensed.heel_up_s.size() == 1);
  CHECK(sensed.heel_up_s[0] == doctest::Approx(2.5 - 17.5 / 200 + .0011).epsilon(.001));
  CHECK(sensed.toe_off_s == sensed.heel_up_s);
  // As a step: 7000 N/s, firm by 2.2 ms.
  sensed = sense({{{.2, 0}, {.3, 700}, {.6, 700}, {.7, 0}}}, kNone, 1);
  REQUIRE(sensed.heel_landing_s.size() == 1);
  CHECK(std::abs(sensed.heel_landing_s[0] - (.2 + 1.05 / 7000 + .0011 + .0035)) < .0006);
  CHECK(sensed.heel_speed[0] == doctest::Approx(.5 * std::pow(10 / 26., 2 / 3.)).epsilon(.1));
}

TEST_CASE("a light touch is a landing and ends below half its threshold, or after half a second") {
  // 4 N for 0.15 s: never 5 %.
  Sensed sensed = sense(kNone, {{{.2, 0}, {.21, 4}, {.35, 4}, {.36, 0}}}, 1);
  REQUIRE(sensed.ball_landing_s.size() == 1);
  REQUIRE(sensed.toe_off_s.size() == 1);
  CHECK(sensed.ball_landing_s[0] - .2 < .0075);
  CHECK(sensed.toe_off_s[0] == doctest::Approx(.36).epsilon(.01));
  sensed = sense(kNone, {{{.2, 0}, {.21, 4}, {3, 4}}}, 3); // a lace that presses
  CHECK(sensed.ball_landing_s.size() == 1);
  REQUIRE(sensed.toe_off_s.size() == 1);
  CHECK(sensed.toe_off_s[0] == doctest::Approx(sensed.ball_landing_s[0] + .5).epsilon(.01));
}

TEST_CASE("no stance ends before 80 ms and no swing before 60 ms") {
  Sensed sensed = sense({{{.2, 0}, {.21, 400}, {.23, 400}, {.24, 0}}}, kNone, 1);
  REQUIRE(sensed.heel_up_s.size() == 1);
  CHECK(sensed.heel_up_s[0] == doctest::Approx(.2025 + .08).epsilon(.01));
  sensed = sense(
      {{{.2, 0}, {.21, 400}, {.40, 400}, {.41, 0}, {.43, 0}, {.44, 400}, {.7, 400}, {.71, 0}}},
      kNone, 1);
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

TEST_CASE(
    "a baseline follows in the air, as slowly as sensors drift upwards and at once downwards") {
  SoleSensor sensor;
  sensor.prepare(kRate);
  const auto settle = [&](double reading, double seconds) {
    SoleState sole;
    for (int n = 0; n < seconds * kRate; ++n)
      sole = sensor.next(reading, 0);
    return sole.heel_n;
  };
  // By 0.4 % of the weight a second.
  const double first = settle(10, .9), second = settle(10, .5);
  CHECK(first - second == doctest::Approx(.5 * .004 * 700).epsilon(.01));
  CHECK(settle(10, 5) < .01);
  CHECK(settle(-5, .3) < .01);
  CHECK(settle(0, .0) < 6);
  const double again = settle(0, .01);
  CHECK(again == doctest::Approx(5).epsilon(.1)); // the baseline had gone down to -5
  // And no lower than 2 % of the weight, 14 N: from -100 back to 0 N reads 14 at most.
  settle(-100, 2);
  CHECK(settle(0, .01) == doctest::Approx(14).epsilon(.1));
}

TEST_CASE(
    "a calibration reads 5 to 32 increasing points, by lines and beyond its ends, until it is "
    "cleared") {
  Calibration table;
  std::vector<double> points;
  for (int i = 0; i < 32; ++i)
    points.insert(points.end(), {static_cast<double>(i), static_cast<double>(i * i)});
  CHECK(table.set(points));
  std::vector<double> many = points, half = points;
  many.insert(many.end(), {32, 1024});
  half.push_back(99);
  for (const std::vector<double>& wrong : {many,
                                           half,
                                           {0, 0, 1, 1, 2, 2, 3, 3},       // too few
                                           {0, 0, 1, 1, 2, 2, 3, 3, 3, 4}, // a reading twice
                                           {0, 0, 1, 1, 2, 2, 3, 3, 4, 3}, // a force twice
                                           {0, 0, 1, 5, 2, 4, 3, 6, 4, 7}, // falling
                                           {0, 0, 1, 1, 2, 2, 3, 3, 4, std::nan("")}})
    CHECK_FALSE(table.set(wrong));
  CHECK(table.force(1) == doctest::Approx(1));
  CHECK(table.force(30.5) == doctest::Approx(.5 * (900 + 961)));
  CHECK(table.force(32) == doctest::Approx(961 + 61));
  CHECK(table.force(-1) == doctest::Approx(-1));
  CHECK(table.set(std::array<double, 10>{0, 0, 1, 10, 2, 30, 3, 70, 4, 150}));
  CHECK(table.force(2.5) == doctest::Approx(50));
  table.clear();
  CHECK(table.force(32) == 32);
}

TEST_CASE("the slope is the least-squares slope of 5 ms, exact for a straight line") {
  for (const double rate : {8000.0, 48000.0}) {
    SoleChannel channel;
    channel.prepare(rate);
    double worst = 0;
    for (int n = 0; n < 60000; ++n) {
      channel.next(3000 * n / rate, SoleChannel::Follow::kStance, 700);
      if (n > 0.02 * rate)
        worst = std::max(worst, std::abs(channel.slope() / 3000 - 1));
    }
    CHECK(worst < 1e-6);
  }
}

TEST_CASE("a rise counts as a touch from seven standard deviations of the noise in the air") {
  constexpr double rate = 8000, weight = 700;
  for (const double deviation : {3.0, 6.0}) { // N, white, before the low-pass
    SoleChannel channel;
    channel.prepare(rate);
    Random random(5);
    double squares = 0, rises = 0, count = 0;
    for (int n = 0; n < 40 * rate; ++n) {
      channel.next(deviation * random.normal(), SoleChannel::Follow::kSwing, weight, true);
      if (n < 2 * rate)
        continue;
      squares += std::pow(channel.touch_threshold_n(weight), 2);
      rises += channel.rise() * channel.rise();
      ++count;
    }
    // The estimate looks back 0.2 s: what it scatters is averaged.
    CHECK(std::sqrt(squares / rises) == doctest::Approx(7).epsilon(.05));
    CHECK(std::sqrt(rises / count) > .1 * deviation);
  }
}

TEST_CASE("a sensor stays finite under invalid input and recovers within a second") {
  SoleSensor sensor;
  sensor.prepare(8000);
  const double odd[] = {std::nan(""), std::numeric_limits<double>::infinity(), -1e308, 1e308,
                        1e-310};
  for (int n = 0; n < 8000; ++n) {
    const SoleState sole = sensor.next(odd[n % 5], odd[(n / 7) % 5]);
    REQUIRE(std::isfinite(sole.heel_n + sole.ball_n + sole.heel_slope + sole.ball_slope));
  }
  bool landed = false;
  for (int n = 0; n < 8000; ++n)
    landed = sensor.next(0, 0).heel_landing > 0;
  CHECK_FALSE(sensor.in_stance());
  for (int n = 0; n < 800; ++n)
    landed = landed || sensor.next(n < 80 ? 6 * n : 480, 0).heel_landing > 0;
  CHECK(landed);
}

namespace {

/// A force-sensing resistor in a divider, as its data sheet has it: conductance ~ F^p, more of it
/// while the force falls (hysteresis of 10 %), drift of 5 % a decade and noise of 1 %. Reads 0..1.
class Resistor {
public:
  static double reading_of(double force_n) {
    const double conductance = 1.2e-4 * std::pow(std::max(force_n, 0.0) / 100, 0.9); // siemens
    return conductance / (conductance + 1 / 3300.0); // of the supply
  }
  double read(double force_n, double t, Random& random) {
    // The loop: the conductance lags behind on the way down.
    lag_ += (force_n > lag_ ? 1.0 : 0.002) * (force_n - lag_);
    const double sensed = force_n + 0.1 * std::min(lag_ - force_n, force_n);
    const double drifted = sensed * (1 + 0.05 * std::log10(1 + t));
    return reading_of(drifted) + 0.01 * random.normal() * reading_of(sensed);
  }

private:
  double lag_ = 0;
};

/// How landings of one part of the left sole were found.
struct Found {
  std::vector<double> truth_s, found_s, truth_speed, found_speed;
  [[nodiscard]] double latest() const {
    double worst = 0;
    for (std::size_t i = 0; i < std::min(truth_s.size(), found_s.size()); ++i)
      worst = std::max(worst, std::abs(found_s[i] - truth_s[i]));
    return worst;
  }
};
struct Feet {
  Found heel, ball;
  std::vector<double> toe_off_s, found_off_s;
};

/// A walk's forces on sensors with noise: multiplicative of 1 %, and additive of `noise` weights at
/// 48 kHz, of the same density at other rates. With `noise` below 0 on resistors, calibrated.
Feet sense_gait(const Walker& walker, double rate, double seconds, double noise,
                const std::function<void(Gait&, double)>& move) {
  Gait gait;
  gait.prepare(rate);
  gait.set(walker, 0.04);
  SoleSensor sensor;
  sensor.prepare(rate);
  sensor.set(walker.weight_n);
  std::vector<double> table;
  for (const double force : {0.0, 20.0, 60.0, 120.0, 250.0, 500.0, 900.0, 1600.0})
    table.insert(table.end(), {Resistor::reading_of(force), force});
  const bool resistors = noise < 0;
  if (resistors) {
    REQUIRE(sensor.heel_calibration().set(table));
    REQUIRE(sensor.ball_calibration().set(table));
  }
  Random random(5);
  Resistor heel, ball;
  const double added = noise * std::sqrt(rate / 48000) * walker.weight_n;
  const auto read = [&](Resistor& resistor, double force, double t) {
    return resistors ? resistor.read(force, std::max(t, 0.), random)
                     : force * (1 + 0.01 * random.normal()) + added * random.normal();
  };
  Feet feet;
  double slip = 0;
  std::array<SoleState, Gait::kFeet> reference{};
  for (int n = -static_cast<int>(0.3 * rate); n < seconds * rate; ++n) { // first in the air
    const double t = n / rate;
    if (n >= 0) {
      move(gait, t);
      gait.next(reference);
    }
    const SoleState& sole = reference[0];
    const SoleState sensed = sensor.next(read(heel, sole.heel_n, t), read(ball, sole.ball_n, t));
    slip += sensed.heel_slip + sensed.ball_slip;
    const auto note = [&](Found& part, double real, double detected) {
      if (real > 0) {
        part.truth_s.push_back(t);
        part.truth_speed.push_back(real);
      }
      if (detected > 0) {
        part.found_s.push_back(t);
        part.found_speed.push_back(detected);
      }
    };
    note(feet.heel, sole.heel_landing, sensed.heel_landing);
    note(feet.ball, sole.ball_landing, sensed.ball_landing);
    if (sole.toe_off)
      feet.toe_off_s.push_back(t);
    if (sensed.toe_off)
      feet.found_off_s.push_back(t);
  }
  CHECK(slip == 0); // forces do not tell
  return feet;
}

void walk_on(Gait& gait, double t) {
  if (t == 0)
    gait.walk(true);
}

double mean(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x)
    sum += value / static_cast<double>(x.size());
  return sum;
}

/// Of landings on sensors with little noise also the second contact is found, and how hard both
/// are.
void check_walker(const Walker& walker, double rate, double seconds, double noise = 0.001) {
  CAPTURE(static_cast<int>(walker.style));
  CAPTURE(walker.speed_m_per_s);
  CAPTURE(walker.weight_n);
  CAPTURE(rate);
  const Feet feet = sense_gait(walker, rate, seconds, noise, walk_on);
  const bool heel_first = feet.heel.truth_s[0] < feet.ball.truth_s[0];
  const Found &first = heel_first ? feet.heel : feet.ball,
              &second = heel_first ? feet.ball : feet.heel;
  for (const Found* part : {&first, &second}) {
    if (noise > 0.001 && part == &second)
      continue;
    CHECK(part->truth_s.size() >= 3);
    CHECK(part->found_s.size() <= part->truth_s.size());
    CHECK(part->found_s.size() + 1 >= part->truth_s.size()); // the last may be the last sample's
    if (noise > 0.001)
      continue;
    CHECK(part->latest() < (part == &first ? 0.006 : 0.009));
    const double ratio = mean(part->found_speed) / mean(part->truth_speed);
    CHECK(ratio > 0.5);
    CHECK(ratio < 2.2);
  }
}

void check_noise_alone(double noise, double rate, double seconds) {
  CAPTURE(noise);
  const Feet feet = sense_gait({1.4, 700, 0.4}, rate, seconds, noise, [](Gait&, double) {});
  CHECK(feet.heel.found_s.empty());
  CHECK(feet.ball.found_s.empty());
}

void check_steps_on_resistors(double seconds) {
  const Feet feet = sense_gait({1.4, 700, 0.4}, 8000, seconds, -1, walk_on);
  REQUIRE(feet.heel.found_s.size() == feet.heel.truth_s.size());
  CHECK(feet.heel.latest() < 0.005);
  REQUIRE(feet.found_off_s.size() + 1 >= feet.toe_off_s.size());
  for (std::size_t k = 0; k < feet.found_off_s.size(); ++k) {
    const double stance = feet.toe_off_s[k] - feet.heel.truth_s[k],
                 found = feet.found_off_s[k] - feet.heel.found_s[k];
    CHECK(std::abs(found / stance - 1) < 0.03);
  }
}

} // namespace

TEST_CASE("a step of any way of walking is felt within 6 ms, its second contact within 9, none is "
          "missed and none made up; noise alone is no step") {
  for (int style = 0; style < 5; ++style)
    for (const double noise : {0.001, 0.004})
      check_walker({1.4, 700, 0.4, static_cast<Style>(style)}, 8000, 5, noise);
  for (const double noise : {0.0, 1e-3, 2e-2})
    check_noise_alone(noise, 8000, 3);
}
TEST_CASE("steps of any weight, speed and rate are felt, and noise of any size is none" *
          doctest::test_suite("slow")) {
  for (int i = 0; i < 5; ++i) {
    const auto style = static_cast<Style>(i);
    for (const double speed : {0.4, 0.8, 1.4, 2.5, 4.0, 7.0})
      for (const double weight : {300.0, 700.0, 1200.0})
        if (style == Style::kRun || speed <= 2.5)
          check_walker({speed, weight, weight == 300 ? 0 : 0.4, style}, 8000, 30);
    check_walker({1.4, 700, 0.4, style}, 48000, 12);
    check_walker({1.4, 700, 0.4, style}, 48000, 15, 0.004);
  }
  for (const double noise : {0.0, 1e-4, 1e-3, 5e-3, 2e-2})
    check_noise_alone(noise, 48000, 20);
}

TEST_CASE("steps on noisy, drifting sensors with hysteresis are each found in time") {
  check_steps_on_resistors(25);
}
TEST_CASE("a thousand steps on noisy, drifting sensors are each found in time" *
          doctest::test_suite("slow")) {
  check_steps_on_resistors(1085);
}

TEST_CASE("a jump's landing, a scuff and a step after a stand are felt through sensors") {
  const Feet feet = sense_gait({1.4, 700, 0.4}, 8000, 12, 0.001, [](Gait& gait, double t) {
    if (t == 0)
      gait.walk(true);
    if (t == 2)
      gait.scuff(0);
    if (t == 4)
      gait.jump(0.3);
    if (t == 8)
      gait.walk(false);
  });
  for (const Found* part : {&feet.heel, &feet.ball}) {
    REQUIRE(part->found_s.size() == part->truth_s.size());
    CHECK(part->latest() < 0.009);
  }
  CHECK(feet.ball.found_s.size() == feet.heel.found_s.size() + 1); // the scuff
}

// ---- sensors that err ----------------------------------------------------------------------

namespace {

/// Walks on sensors that add what `fault` makes of the forces and the time; every first contact is
/// found once, and no second one is made up.
void check_fault(const char* name,
                 const std::function<void(double&, double&, double, Random&)>& fault) {
  CAPTURE(name);
  Gait gait;
  gait.prepare(8000);
  gait.set({1.4, 700, 0.4}, 0.04);
  gait.walk(true);
  SoleSensor sensor;
  sensor.prepare(8000);
  sensor.set(700);
  Random random(3);
  std::array<SoleState, Gait::kFeet> reference{};
  std::vector<double> truth, found;
  int balls = 0, found_balls = 0;
  for (int n = -4000; n < 20 * 8000; ++n) {
    if (n >= 0)
      gait.next(reference);
    double heel = reference[0].heel_n, ball = reference[0].ball_n;
    fault(heel, ball, n / 8000., random);
    const SoleState sensed = sensor.next(heel, ball);
    if (reference[0].heel_landing > 0)
      truth.push_back(n / 8000.);
    if (sensed.heel_landing > 0)
      found.push_back(n / 8000.);
    balls += reference[0].ball_landing > 0;
    found_balls += sensed.ball_landing > 0;
  }
  REQUIRE(found.size() == truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i)
    CHECK(std::abs(found[i] - truth[i]) < 0.01);
  CHECK(std::abs(balls - found_balls) <= 1); // the last may be the last sample's
}

} // namespace

TEST_CASE("cross-talk, hum and drift of the sensors make no step and hide none") {
  check_fault("5 % cross-talk and 2 N of noise",
              [](double& heel, double& ball, double, Random& random) {
                const double h = heel;
                heel += 0.05 * ball + 2 * random.normal();
                ball += 0.05 * h + 2 * random.normal();
              });
  for (const double hz : {50., 60.})
    check_fault("20 N of hum, rms", [hz](double& heel, double& ball, double t, Random&) {
      const double hum = 20 * std::sqrt(2.) * std::sin(2 * 3.14159265358979 * hz * t);
      heel += hum;
      ball += hum;
    });
  for (const double up : {1., -1.})
    check_fault("100 N of drift and back in 20 s",
                [up](double& heel, double& ball, double t, Random&) {
                  const double drift = up * 50 * (1 - std::cos(2 * 3.14159265358979 * t / 20));
                  heel += drift;
                  ball += drift;
                });
}

TEST_CASE(
    "a sensor plugged in under load is no landing, and one that is read at 50 Hz is none less") {
  const Line plugged{{{1, 0}, {1, 300}, {3, 300}}};
  const Sensed sensed = sense(plugged, plugged, 3);
  CHECK(sensed.heel_landing_s.empty());
  CHECK(sensed.ball_landing_s.empty());
  Line slow{{{0, 0}}};
  for (int i = 1; i < 40; ++i) { // each reading held for 20 ms
    const double t = 0.02 * i, force = i < 10 || i > 35 ? 0 : std::min(700., 200. * (i - 9));
    slow.points.push_back({t, slow.points.back()[1]});
    slow.points.push_back({t, force});
  }
  const Sensed step = sense(slow, kNone, 1);
  REQUIRE(step.heel_landing_s.size() == 1);
  CHECK(step.heel_landing_s[0] < .2 + .025);
  CHECK(step.heel_speed[0] == doctest::Approx(.5).epsilon(.5));
  CHECK(step.toe_off_s.size() == 1);
}

TEST_CASE("who stands and shifts the weight makes no step, however slowly the foot was put down") {
  for (const double put_s : {0.5, 1., 4.})
    for (const double min_n : {30., 50.}) {
      CAPTURE(put_s);
      CAPTURE(min_n);
      Line line{{{.5, 0}, {.5 + put_s, min_n}}};
      for (double t = 1 + put_s; t < 16; t += 1 / 0.3) { // a part of the sole, at 0.3 Hz
        line.points.push_back({t, min_n});
        line.points.push_back({t + 1.4, 320});
        line.points.push_back({t + 1.9, 320});
      }
      const Sensed sensed = sense(line, line, 16);
      CHECK(sensed.heel_landing_s.size() <= 1);
      CHECK(sensed.ball_landing_s.size() <= 1);
      CHECK(sensed.toe_off_s.size() == 0);
    }
}

#include "core/haptic/chain/thermal.hpp"
#include "tests/core/haptic/rig.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace tactus::haptic;
using test::approx;

namespace {

constexpr double kPeak_n = 3.3, kRated_n = 0.88; // of a Touch, which holds the latter for ever
constexpr ThermalSettings kTouch{1e-3, kPeak_n, kRated_n};

struct TouchServo : test::HostedServo<test::Recorder> {
  explicit TouchServo(ChainSettings chain = {}) {
    chain.force_limit_n = kPeak_n;
    set(chain);
    device.given.peak_force_n = kPeak_n;
    device.given.continuous_force_n = kRated_n;
    attach();
  }
  /// The force at the end of those seconds in which the patch asks for that force.
  double ask(double force_n, double seconds) {
    run(static_cast<int>(seconds * 1e3 + 0.5), {force_n, 0, 0});
    return device.forces.back().x;
  }
  [[nodiscard]] double largest_fall_n(std::size_t from = 1) const {
    double largest = 0;
    for (std::size_t i = from; i < device.forces.size(); ++i)
      largest = std::max(largest, device.forces[i - 1].x - device.forces[i].x);
    return largest;
  }
};

void check_lasting_force(double commanded_n, int seconds) {
  TouchServo rig;
  rig.ask(commanded_n, seconds);
  double mean_n = 0; // of the last third
  const auto ticks = rig.device.forces.size();
  for (std::size_t i = ticks / 3 * 2; i < ticks; ++i)
    mean_n += rig.device.forces[i].x / static_cast<double>(ticks / 3);
  CAPTURE(commanded_n);
  CHECK(mean_n < kRated_n);
  CHECK(mean_n > 0.8);                                    // no more is taken than must be
  CHECK(rig.largest_fall_n() < 3e-3);                     // a ramp of 3 N/s at the most
  CHECK(rig.device.forces[200].x == approx(commanded_n)); // a short push has all of it
  CHECK(rig.servo.chain().derating);
}

} // namespace

TEST_CASE("the heat follows the squared force with one time constant") {
  ThermalLimit motors;
  for (int tick = 0; tick < 30000; ++tick)
    motors.advance({1e-3, 8, 1}, 2, false);
  CHECK(motors.heat_n2() == approx(4 * (1 - std::exp(-1.0))).epsilon(1e-9));
}

TEST_CASE("the peak force requested for ever settles below the continuous rating") {
  check_lasting_force(3.3, 30);
}

TEST_CASE("any force requested for ever settles below the continuous rating" *
          doctest::test_suite("slow")) {
  for (const double commanded_n : {1.0, 2.0, 3.3})
    check_lasting_force(commanded_n, 180);
}

TEST_CASE("the rating holds without the passivity controller, and no new connection cools motors") {
  TouchServo rig(test::without_passivity());
  CHECK(rig.ask(kPeak_n, 20) < kRated_n);
  rig.servo.detach();
  rig.attach();
  CHECK(rig.ask(kPeak_n, 1) < kRated_n);
}

TEST_CASE("pushes with pauses, below the rating in the mean, are not limited") {
  ThermalLimit motors;
  for (int tick = 0; tick < 120000; ++tick) { // 2 N for 0.1 s of each 2 s: 0.45 N rms
    motors.advance(kTouch, tick % 2000 < 100 ? 2 : 0, false);
    REQUIRE(motors.ceiling_n(kTouch) == kPeak_n);
  }
  CHECK_FALSE(motors.derating());
}

TEST_CASE("a device without a rating, or with one at its peak, is never derated") {
  for (const double rated : {0.0, 8.0}) {
    ThermalLimit motors;
    const ThermalSettings settings{1e-3, 8, rated};
    for (int tick = 0; tick < 100000; ++tick)
      motors.advance(settings, 8, false);
    CHECK(motors.ceiling_n(settings) == approx(8));
    CHECK(motors.steady_limit_n(settings) == approx(8));
  }
}

TEST_CASE("a device that reports warm motors gets less force within a second, by a ramp") {
  TouchServo rig;
  CHECK(rig.ask(1, 0.5) == approx(1));
  rig.device.reading.flags = State::kHomed | State::kMotorsHot;
  const std::size_t before = rig.device.forces.size();
  CHECK(rig.ask(1, 1.5) == approx(0.44).epsilon(1e-6)); // half the rating
  CHECK(rig.largest_fall_n(before) < 4e-3);
  CHECK(rig.report().derating);
  CHECK(rig.report().derated_to_n == approx(0.44));
  rig.device.reading.flags = State::kHomed; // back to the peak in ten seconds
  CHECK(rig.ask(1, 1) == approx(0.9 * 0.44 + 0.1 * kPeak_n).epsilon(0.03));
  CHECK(rig.ask(1, 10) > 0.85);
}

TEST_CASE("the reported limit is the one at which a lasting force settles") {
  for (const double peak : {1.0, 3.3, 20.0})
    for (const double rated : {0.3, 0.88}) {
      ThermalLimit motors;
      const ThermalSettings settings{1e-3, peak, rated};
      for (int tick = 0; tick < 200000; ++tick)
        motors.advance(settings, motors.ceiling_n(settings), false);
      CHECK(motors.steady_limit_n(settings) == approx(motors.ceiling_n(settings)).epsilon(1e-5));
      CHECK(motors.derating());
    }
}

TEST_CASE("late ticks heat the motors for as long as they hold the force, a stall for 50 ms") {
  TouchServo rig;
  const auto step = [&rig](double time_s) {
    rig.servo.exchange().commands.write({{0.5, 0, 0}, ++rig.number, 0, false, time_s});
    rig.servo.step({static_cast<std::uint64_t>(time_s * 1e3 + 0.5), time_s, 1e-3});
    return rig.report().heat_n2;
  };
  double after_30_s = 0;
  for (int tick = 0; tick < 10000; ++tick)
    after_30_s = step(3e-3 * tick); // two of three ticks are skipped
  CHECK(after_30_s == approx(0.25 * (1 - std::exp(-1.0))).epsilon(1e-3));
  const double kept = std::exp(-0.05 / 30);
  CHECK(step(60) == approx(kept * after_30_s + (1 - kept) * 0.25).epsilon(1e-6));
}

TEST_CASE("motors that were warm under another servo start with their heat") {
  TouchServo rig;
  rig.servo.set_motor_heat(kRated_n * kRated_n);
  rig.attach();
  CHECK(rig.ask(kPeak_n, 0.1) < 0.9);
  CHECK(rig.report().derating);
  CHECK(rig.report().derated_to_n == approx(0.877).epsilon(1e-3));
  CHECK(rig.report().heat_n2 == approx(0.7744).epsilon(0.01));
  for (const double heat : {std::nan(""), -1.0})
    CHECK(ThermalLimit(heat).heat_n2() == 0);
}

TEST_CASE("motors count as warm until they are well below where the limit begins to fall") {
  ThermalLimit motors;
  while (!motors.derating())
    motors.advance(kTouch, kPeak_n, false);
  CHECK(motors.ceiling_n(kTouch) > 0.9 * kPeak_n);
  while (motors.ceiling_n(kTouch) < kPeak_n)
    motors.advance(kTouch, 0, false);
  CHECK(motors.derating());
  while (motors.heat_n2() > 0.401 * kRated_n * kRated_n)
    motors.advance(kTouch, 0, false);
  CHECK(motors.derating());
  for (int tick = 0; tick < 200; ++tick)
    motors.advance(kTouch, 0, false);
  CHECK_FALSE(motors.derating());
}

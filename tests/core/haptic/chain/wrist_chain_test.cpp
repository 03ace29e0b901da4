#include "tests/core/haptic/rig.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace tactus::haptic;
using tactus::Vec3;
using test::approx;

namespace {

constexpr double kPeriod_s = 1e-3;

Caps sigma() {
  Caps caps;
  caps.peak_torque_n_m = 0.2;
  caps.peak_grip_n = 8;
  return caps;
}

/// A device with a wrist, for which the patch asks for torque and grip.
struct WristServo : test::HostedServo<test::Recorder> {
  WristServo() {
    device.given = sigma();
    attach();
    want(true);
  }
  void want(bool on) { servo.exchange().wrist.write({on, {{0.1, 0, 0}, 3}}); }
  const WristCommand& after(int ticks) {
    run(ticks, {});
    return device.wrist;
  }
};

} // namespace

TEST_CASE("a device is not asked for torque or grip unless the patch has switched them on") {
  WristServo rig;
  rig.want(false);
  CHECK(rig.after(1000) == WristCommand{});
  CHECK(rig.device.wrist_requests == 0);
  rig.want(true);
  CHECK(rig.after(1000).torque_n_m.x == approx(0.1));
  CHECK(rig.device.wrist.grip_n == approx(3));
  rig.want(false);
  CHECK(rig.after(1) == WristCommand{});
}

TEST_CASE("torque and grip rise by the slew, to the device's peak and no further") {
  WristChain chain;
  ChainState state;
  const WristCommand desired{{0.3, 0.4, 0}, -20};
  WristCommand last;
  int ticks = 0;
  for (; ticks < 100; ++ticks) {
    const WristCommand sent = chain.step(desired, state, sigma(), true, kPeriod_s);
    CHECK(norm(sent.torque_n_m - last.torque_n_m) <= 0.2 * kPeriod_s / WristChain::kRise_s + 1e-12);
    CHECK(std::abs(sent.grip_n - last.grip_n) <= 8 * kPeriod_s / WristChain::kRise_s + 1e-12);
    if (norm(sent.torque_n_m - last.torque_n_m) < 1e-12)
      break;
    last = sent;
  }
  CHECK(ticks == 20);
  CHECK(norm(last.torque_n_m - Vec3{0.12, 0.16, 0}) < 1e-12); // in the same direction
  CHECK(last.grip_n == approx(-8));
}

TEST_CASE("a request that is not finite counts as zero") {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  WristChain chain;
  for (int i = 0; i < 100; ++i)
    CHECK(chain.step({{kNaN, 0.1, 0}, -1 / 0.0}, {}, sigma(), true, i % 2 ? kPeriod_s : kNaN) ==
          WristCommand{});
}

TEST_CASE("after a stop, without homing and at an unreachable pose torque and grip are zero at "
          "that tick") {
  WristServo rig;
  for (const std::uint32_t flags :
       {0u, State::kHomed | State::kUnreachable, State::kHomed | State::kFault}) {
    rig.device.reading.flags = State::kHomed;
    CHECK(rig.after(2000).grip_n == approx(3));
    rig.device.reading.flags = flags;
    CHECK(rig.after(1) == WristCommand{});
    CHECK(rig.after(100) == WristCommand{});
    // Back by the enable time; after a fault only by motors 1.
    rig.device.reading.flags = State::kHomed;
    CHECK(rig.after(1).grip_n < 0.1);
  }
  CHECK(rig.after(2000) == WristCommand{}); // the fault is latched
}

TEST_CASE("torque and grip are zero after the watchdog's time without the host") {
  WristServo rig;
  rig.run(2000, {});
  const auto after = [&rig](int ticks) {
    for (; ticks > 0; --ticks, ++rig.tick)
      rig.servo.step({rig.tick, kPeriod_s * static_cast<double>(rig.tick), kPeriod_s});
    return rig.device.wrist;
  };
  CHECK(after(90).grip_n == approx(3));
  CHECK(after(35).grip_n == approx(1.5).epsilon(0.1)); // hold 100 ms, ramp 50 ms
  CHECK(after(30) == WristCommand{});
}

TEST_CASE("a torque maps like the cross product of mapped vectors") {
  const Vec3 lever{0.1, -0.2, 0.3}, force{4, 5, -6};
  for (const char* axes : {"xyz", "yzx", "zxy", "xzy", "yxz", "zyx"})
    for (int signs = 0; signs < 8; ++signs) {
      const auto map = AxisMap::parse(
          axes, {signs & 1 ? -1.0 : 1.0, signs & 2 ? -1.0 : 1.0, signs & 4 ? -1.0 : 1.0});
      REQUIRE(map);
      const Vec3 expected = cross(map->to_device(lever), map->to_device(force));
      CHECK(norm(map->torque_to_device(cross(lever, force)) - expected) < 1e-12);
      CHECK(norm(map->rotation_to_project(expected) - cross(lever, force)) < 1e-12);
    }
}

TEST_CASE(
    "motors are at rest when torque and grip are gone, too, and a new device begins with none") {
  WristServo rig;
  rig.run(1000, {});
  MotorControl& motors = rig.servo.exchange().motors;
  CHECK_FALSE(motors.zero_force_confirmed()); // there is no force, but a torque
  motors.pause(true);
  rig.run(1, {});
  CHECK_FALSE(motors.zero_force_confirmed()); // it falls by the slew
  rig.run(30, {});
  CHECK(motors.zero_force_confirmed());
  motors.pause(false);
  rig.run(1000, {});
  rig.attach();
  CHECK(rig.after(1).grip_n <= 8 * kPeriod_s / WristChain::kRise_s + 1e-12);
}

#include "core/haptic/servo/servo.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace tactus::haptic;

namespace {

constexpr double kPeriod_s = 1e-3;

Caps sigma() {
  Caps caps;
  caps.peak_torque_n_m = 0.2;
  caps.peak_grip_n = 8;
  return caps;
}

/// A device with a wrist, which keeps what it was sent and how often it was asked.
struct Wrist final : Backend {
  std::string open() override { return {}; }
  void close() noexcept override {}
  Caps caps() const noexcept override { return sigma(); }
  bool read(const Tick&, State& state) noexcept override {
    state.flags = flags;
    return true;
  }
  bool write(const Vec3&) noexcept override {
    sent = next;
    next = {};
    return true;
  }
  void set_wrist(const WristCommand& command) noexcept override {
    next = command;
    ++asked;
  }
  std::uint32_t flags = State::kHomed;
  WristCommand next{}, sent{};
  int asked = 0;
};

struct Rig {
  Wrist device;
  Servo servo;
  std::uint64_t index = 0;
  double heartbeat_s = -1; ///< -1: the host is alive

  Rig() { servo.attach(device); }
  void want(bool on, const Vec3& torque_n_m, double grip_n) {
    servo.exchange().wrist.write({on, {torque_n_m, grip_n}});
  }
  void tick(int count) {
    for (int i = 0; i < count; ++i, ++index) {
      const double time_s = kPeriod_s * static_cast<double>(index);
      Command command;
      command.heartbeat_s = heartbeat_s < 0 ? time_s : heartbeat_s;
      servo.exchange().commands.write(command);
      servo.step({index, time_s, kPeriod_s});
    }
  }
};

} // namespace

TEST_CASE("a device is not asked for torque or grip unless the patch has switched them on") {
  Rig rig;
  rig.want(false, {0.1, 0, 0}, 3);
  rig.tick(1000);
  CHECK(rig.device.asked == 0);
  rig.want(true, {0.1, 0, 0}, 3);
  rig.tick(1000);
  CHECK(rig.device.sent.torque_n_m.x == doctest::Approx(0.1));
  CHECK(rig.device.sent.grip_n == doctest::Approx(3));
  rig.want(false, {0.1, 0, 0}, 3);
  rig.tick(1);
  CHECK(rig.device.sent.torque_n_m == Vec3{});
  CHECK(rig.device.sent.grip_n == 0);
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
  CHECK(last.grip_n == doctest::Approx(-8));
}

TEST_CASE("a request that is not finite counts as zero") {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  WristChain chain;
  ChainState state;
  for (int i = 0; i < 100; ++i) {
    const WristCommand sent =
        chain.step({{kNaN, 0.1, 0}, -1 / 0.0}, state, sigma(), true, i % 2 ? kPeriod_s : kNaN);
    CHECK(is_finite(sent.torque_n_m));
    CHECK(std::isfinite(sent.grip_n));
    CHECK(norm(sent.torque_n_m) == 0);
    CHECK(sent.grip_n == 0);
  }
}

TEST_CASE("after a stop, without homing and at an unreachable pose torque and grip are zero at "
          "that tick") {
  Rig rig;
  rig.want(true, {0.1, 0, 0}, 3);
  const auto none = [&] {
    return rig.device.sent.torque_n_m == Vec3{} && rig.device.sent.grip_n == 0;
  };
  for (const std::uint32_t flags :
       {std::uint32_t{0}, std::uint32_t{State::kHomed | State::kUnreachable},
        std::uint32_t{State::kHomed | State::kFault}}) {
    rig.device.flags = State::kHomed;
    rig.tick(2000);
    if (flags != (State::kHomed | State::kFault))
      REQUIRE(rig.device.sent.grip_n == doctest::Approx(3));
    rig.device.flags = flags;
    rig.tick(1);
    CHECK(none());
    rig.tick(100);
    CHECK(none());
    // Back by the enable time; after a fault only by motors 1.
    rig.device.flags = State::kHomed;
    rig.tick(1);
    CHECK(rig.device.sent.grip_n < 0.1);
  }
  rig.tick(2000);
  CHECK(none()); // the fault is latched
}

TEST_CASE("torque and grip are zero after the watchdog's time without the host") {
  Rig rig;
  rig.want(true, {0.1, 0, 0}, 3);
  rig.tick(2000);
  rig.heartbeat_s = kPeriod_s * static_cast<double>(rig.index);
  rig.tick(90);
  CHECK(rig.device.sent.grip_n == doctest::Approx(3));
  rig.tick(35); // hold 100 ms, ramp 50 ms
  CHECK(rig.device.sent.grip_n == doctest::Approx(1.5).epsilon(0.1));
  rig.tick(30);
  CHECK(rig.device.sent.torque_n_m == Vec3{});
  CHECK(rig.device.sent.grip_n == 0);
}

TEST_CASE("a torque maps like the cross product of mapped vectors") {
  const auto cross = [](const Vec3& a, const Vec3& b) {
    return Vec3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  };
  const Vec3 lever{0.1, -0.2, 0.3}, force{4, 5, -6};
  for (const char* axes : {"xyz", "yzx", "zxy", "xzy", "yxz", "zyx"})
    for (int signs = 0; signs < 8; ++signs) {
      const auto map = AxisMap::parse(
          axes, {signs & 1 ? -1.0 : 1.0, signs & 2 ? -1.0 : 1.0, signs & 4 ? -1.0 : 1.0});
      REQUIRE(map);
      const Vec3 expected = cross(map->to_device(lever), map->to_device(force));
      CHECK(norm(map->torque_to_device(cross(lever, force)) - expected) < 1e-12);
    }
}

TEST_CASE(
    "motors are at rest when torque and grip are gone, too, and a new device begins with none") {
  Rig rig;
  rig.want(true, {0.1, 0, 0}, 3);
  rig.tick(1000);
  MotorControl& motors = rig.servo.exchange().motors;
  CHECK_FALSE(motors.zero_force_confirmed()); // there is no force, but a torque
  motors.pause(true);
  rig.tick(1);
  CHECK_FALSE(motors.zero_force_confirmed()); // it falls by the slew
  rig.tick(30);
  CHECK(motors.zero_force_confirmed());
  motors.pause(false);
  rig.tick(1000);
  rig.servo.attach(rig.device);
  rig.tick(1);
  CHECK(rig.device.sent.grip_n <= 8 * kPeriod_s / WristChain::kRise_s + 1e-12);
}

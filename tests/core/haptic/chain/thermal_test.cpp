#include "core/haptic/chain/thermal.hpp"
#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/servo/servo.hpp"
#include "tests/core/haptic/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

using namespace tactus::haptic;
using tactus::haptic::test::approx;

namespace {

/// A Touch: 3.3 N at the peak, 0.88 N for ever.
struct Touch final : Backend {
  std::string open() override { return {}; }
  void close() noexcept override {}
  Caps caps() const noexcept override {
    Caps caps;
    caps.peak_force_n = 3.3;
    caps.continuous_force_n = 0.88;
    return caps;
  }
  bool read(const Tick&, State& state) noexcept override {
    state.flags = State::kHomed | (warm ? State::kMotorsHot : 0u);
    return true;
  }
  bool write(const Vec3& force_n) noexcept override {
    forces.push_back(norm(force_n));
    return true;
  }
  bool warm = false;
  std::vector<double> forces;
};

/// The device's forces while a patch asks for so much, one a millisecond.
void ask(Servo& servo, std::uint64_t& tick, double force_n, double seconds) {
  for (const auto end = tick + static_cast<std::uint64_t>(seconds * 1e3); tick < end; ++tick) {
    Command command;
    command.force_n = {force_n, 0, 0};
    command.number = tick + 1;
    command.heartbeat_s = static_cast<double>(tick) * 1e-3;
    servo.exchange().commands.write(command);
    servo.step({tick, static_cast<double>(tick) * 1e-3, 1e-3});
  }
}

void attach(Touch& device, Servo& servo) {
  ServoSettings settings;
  settings.chain.force_limit_n = 3.3;
  servo.exchange().settings.write(settings);
  servo.attach(device);
}

} // namespace

TEST_CASE("the heat follows the squared force with one time constant") {
  ThermalLimit motors;
  const ThermalSettings settings{1e-3, 8, 1};
  for (int tick = 0; tick < 30000; ++tick)
    motors.advance(settings, 2, false);
  CHECK(motors.heat_n2() == approx(4 * (1 - std::exp(-1.0))).epsilon(1e-9));
}

TEST_CASE("a force requested for ever settles below the continuous rating") {
  for (const double commanded_n : {1.0, 2.0, 3.3}) {
    Touch device;
    Servo servo;
    attach(device, servo);
    std::uint64_t tick = 0;
    ask(servo, tick, commanded_n, 180);
    double sum = 0, largest_step = 0;
    for (std::size_t i = 1; i < device.forces.size(); ++i) {
      if (i + 60000 > device.forces.size())
        sum += device.forces[i] * 1.0 / 60000;
      largest_step = std::max(largest_step, device.forces[i - 1] - device.forces[i]);
    }
    CAPTURE(commanded_n);
    MESSAGE("asked for " << commanded_n << " N: " << sum << " N in the third minute; largest fall "
                         << largest_step * 1e3 << " N/s");
    CHECK(sum < 0.88);
    CHECK(sum > 0.8);                                 // no more is taken than must be
    CHECK(largest_step < 3e-3);                       // a ramp of 3 N/s at the most
    CHECK(device.forces[200] == approx(commanded_n)); // a short push has all of it
    CHECK(servo.chain().derating);
  }
}

TEST_CASE("the rating holds without the passivity controller, and no new connection cools motors") {
  Touch device;
  Servo servo;
  ServoSettings settings;
  settings.chain.force_limit_n = 3.3;
  settings.chain.passivity = false;
  servo.exchange().settings.write(settings);
  servo.attach(device);
  std::uint64_t tick = 0;
  ask(servo, tick, 3.3, 60);
  CHECK(device.forces.back() < 0.88);
  servo.detach();
  servo.attach(device);
  ask(servo, tick, 3.3, 1);
  CHECK(device.forces.back() < 0.88);
}

TEST_CASE("pushes with pauses, below the rating in the mean, are not limited") {
  Touch device;
  Servo servo;
  attach(device, servo);
  std::uint64_t tick = 0;
  for (int push = 0; push < 60; ++push) { // 2 N for 0.1 s of each 2 s: 0.45 N rms
    ask(servo, tick, 2, 0.1);
    CHECK(device.forces.back() == approx(2));
    ask(servo, tick, 0, 1.9);
  }
  CHECK_FALSE(servo.chain().derating);
}

TEST_CASE("a device without a rating, or with one at its peak, is never derated") {
  for (const double rated : {0.0, 8.0}) {
    ThermalLimit motors;
    const ThermalSettings settings{1e-3, 8, rated};
    for (int tick = 0; tick < 300000; ++tick)
      motors.advance(settings, 8, false);
    CHECK(motors.ceiling_n(settings) == approx(8));
  }
}

TEST_CASE("a device that reports warm motors gets less force within a second, by a ramp") {
  Touch device;
  Servo servo;
  attach(device, servo);
  std::uint64_t tick = 0;
  ask(servo, tick, 1, 0.5);
  CHECK(device.forces.back() == approx(1));
  device.warm = true;
  const std::size_t before = device.forces.size();
  ask(servo, tick, 1, 1.5);
  CHECK(device.forces.back() == approx(0.44).epsilon(1e-6)); // half the rating
  for (std::size_t i = before; i < device.forces.size(); ++i)
    REQUIRE(device.forces[i - 1] - device.forces[i] < 4e-3);
  CHECK(servo.chain().derating);
  device.warm = false;
  ask(servo, tick, 1, 11);
  CHECK(device.forces.back() > 0.85);
}

TEST_CASE("for any ratings the limit is finite and never above the peak") {
  for (const double peak : {0.0, 1e-3, 8.0})
    for (const double rated : {0.0, 1e-6, 1.0, 1e3})
      for (const double force : {0.0, 8.0, 1e6}) {
        ThermalLimit motors;
        const ThermalSettings settings{1e-3, peak, rated};
        for (int tick = 0; tick < 2000; ++tick) {
          motors.advance(settings, force, tick % 2 == 0);
          const double ceiling = motors.ceiling_n(settings);
          REQUIRE(std::isfinite(ceiling));
          REQUIRE(ceiling >= 0);
          REQUIRE(ceiling <= peak);
        }
      }
}

TEST_CASE("the reported limit is the one at which a lasting force settles") {
  for (const double peak : {1.0, 2.0, 3.3, 20.0})
    for (const double rated : {0.3, 0.88}) {
      ThermalLimit motors;
      const ThermalSettings settings{1e-3, peak, rated};
      for (int tick = 0; tick < 200000; ++tick)
        motors.advance(settings, motors.ceiling_n(settings), false);
      CHECK(motors.steady_limit_n(settings) ==
            doctest::Approx(motors.ceiling_n(settings)).epsilon(1e-6));
      CHECK(motors.derating());
    }
}

TEST_CASE("pushes near the limit do not switch the report of warm motors with every push") {
  ThermalLimit motors;
  const ThermalSettings settings{1e-3, 3.3, 0.88};
  int changes = 0;
  bool before = false;
  for (int tick = 0; tick < 300000; ++tick) {
    const double force_n = tick % 2000 < 140 ? motors.ceiling_n(settings) : 0; // 0.87 N rms asked
    motors.advance(settings, force_n, false);
    changes += motors.derating() != before;
    before = motors.derating();
  }
  CHECK(changes == 1);
  for (int tick = 0; tick < 40000; ++tick)
    motors.advance(settings, 0, false);
  CHECK_FALSE(motors.derating());
}

TEST_CASE("the servo's report has warm motors and the limit at which their force settles") {
  Touch device;
  Servo servo;
  attach(device, servo);
  std::uint64_t tick = 0;
  ask(servo, tick, 3.3, 5);
  servo.exchange().reports.read();
  CHECK(servo.exchange().reports.latest().derating);
  CHECK(servo.exchange().reports.latest().derated_to_n == doctest::Approx(0.877).epsilon(1e-3));
  device.warm = true;
  ask(servo, tick, 3.3, 0.1);
  servo.exchange().reports.read();
  CHECK(servo.exchange().reports.latest().derated_to_n == doctest::Approx(0.44));
}

TEST_CASE("late ticks heat the motors for as long as they hold the force, a stall for 50 ms") {
  Touch device;
  Servo servo;
  attach(device, servo);
  Command command;
  command.force_n = {0.5, 0, 0};
  const auto step = [&](double time_s) {
    command.heartbeat_s = time_s;
    ++command.number;
    servo.exchange().commands.write(command);
    servo.step({static_cast<std::uint64_t>(time_s * 1e3 + 0.5), time_s, 1e-3});
  };
  for (int tick = 0; tick < 10000; ++tick)
    step(3e-3 * tick); // two of three ticks are skipped
  const double after_30_s = servo.chain().thermal.heat_n2();
  CHECK(after_30_s == doctest::Approx(0.25 * (1 - std::exp(-1.0))).epsilon(1e-3));
  step(60);
  const double kept = std::exp(-0.05 / 30);
  CHECK(servo.chain().thermal.heat_n2() ==
        doctest::Approx(kept * after_30_s + (1 - kept) * 0.25).epsilon(1e-6));
}

TEST_CASE("motors that were warm under another servo start with their heat") {
  Touch device;
  Servo servo;
  servo.set_motor_heat(0.88 * 0.88);
  attach(device, servo);
  std::uint64_t tick = 0;
  ask(servo, tick, 3.3, 0.1);
  CHECK(device.forces.back() < 0.9);
  CHECK(servo.chain().derating);
  servo.exchange().reports.read();
  CHECK(servo.exchange().reports.latest().heat_n2 == doctest::Approx(0.7744).epsilon(0.01));
  for (const double heat : {std::nan(""), -1.0})
    CHECK(ThermalLimit(heat).heat_n2() == 0);
}

TEST_CASE("motors count as warm until they are well below where the limit begins to fall") {
  ThermalLimit motors;
  const ThermalSettings settings{1e-3, 3.3, 0.88};
  while (!motors.derating())
    motors.advance(settings, 3.3, false);
  CHECK(motors.ceiling_n(settings) > 0.9 * 3.3);
  while (motors.ceiling_n(settings) < 3.3)
    motors.advance(settings, 0, false);
  CHECK(motors.derating());
  while (motors.heat_n2() > 0.401 * 0.88 * 0.88)
    motors.advance(settings, 0, false);
  CHECK(motors.derating());
  for (int tick = 0; tick < 200; ++tick)
    motors.advance(settings, 0, false);
  CHECK_FALSE(motors.derating());
}

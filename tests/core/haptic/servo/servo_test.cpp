#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/servo/servo.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

using namespace tactus::haptic;

namespace {

struct FakeClock final : Clock {
  double now_s() noexcept override { return now; }
  double now = 0;
};

/// A device that records what is written and fails on demand.
struct Recorder final : Backend {
  std::string open() override { return {}; }
  void close() noexcept override {}
  Caps caps() const noexcept override { return given; }
  bool read(const Tick& tick, State& state) noexcept override {
    ticks.push_back(tick);
    state = reading;
    return readable;
  }
  bool write(const Vec3& force) noexcept override {
    forces.push_back(force);
    return writable;
  }
  Caps given{};
  State reading{};
  bool readable = true, writable = true;
  std::vector<Tick> ticks;
  std::vector<Vec3> forces;
};

Command force_x(double newtons, double heartbeat_s, std::uint64_t number = 1) {
  Command c;
  c.force_n = {newtons, 0, 0};
  c.number = number;
  c.heartbeat_s = heartbeat_s;
  return c;
}

/// A servo on an injected clock without passivity control, with a force of 2 N from the time 0.
struct ClockedServo {
  FakeClock clock;
  Recorder device;
  Servo servo;
  ClockedServo() {
    ServoSettings settings;
    settings.chain.passivity = false;
    servo.exchange().settings.write(settings);
    servo.attach(device);
    servo.start(clock, 1e-3);
    servo.exchange().commands.write(force_x(2, 0));
  }
};

} // namespace

TEST_CASE("a wake-up 3.5 ms late runs its tick once, skips three grid points and keeps the phase") {
  FakeClock clock;
  clock.now = 10.0;
  Recorder device;
  Servo servo;
  servo.attach(device);
  servo.start(clock, 1e-3);
  for (int k = 0; k < 5; ++k) {
    clock.now = servo.deadline_s();
    servo.wake(clock);
  }
  CHECK(servo.deadline_s() == doctest::Approx(10.005).epsilon(1e-12));
  clock.now = 10.005 + 0.0035;
  servo.wake(clock);
  CHECK(device.ticks.size() == 6);
  CHECK(device.ticks.back().index == 8);
  CHECK(device.ticks.back().time_s == clock.now);
  CHECK(servo.statistics().skipped == 3);
  CHECK(servo.statistics().overruns == 1);
  CHECK(servo.statistics().ticks == 6);
  CHECK(servo.deadline_s() == doctest::Approx(10.009).epsilon(1e-12));
  CHECK(servo.statistics().lateness.max_s() == doctest::Approx(0.0035).epsilon(1e-9));
  clock.now = servo.deadline_s() + 0.0004;
  servo.wake(clock);
  CHECK(servo.statistics().skipped == 3);
  CHECK(device.ticks.back().index == 9);
}

TEST_CASE("any sequence of wake-ups keeps the grid: ticks run and skipped add up") {
  Pacer pacer;
  pacer.start(5.0, 1.0 / 3000);
  tactus::Random random(4);
  std::uint64_t run = 0, skipped = 0;
  for (int i = 0; i < 20000; ++i) {
    const double late = random.next() % 50 == 0 ? 0.01 * random.uniform() : 1e-4 * random.uniform();
    const auto wake = pacer.wake(pacer.deadline_s() + late);
    CHECK(wake.tick.index == run + skipped + wake.skipped);
    ++run;
    skipped += wake.skipped;
    CHECK(pacer.deadline_s() == doctest::Approx(5.0 + static_cast<double>(run + skipped) / 3000));
  }
}

TEST_CASE("after the host stops the force is half at 125 ms, zero at 150 ms, and back in 50 ms") {
  ClockedServo rig;
  FakeClock& clock = rig.clock;
  Recorder& device = rig.device;
  Servo& servo = rig.servo;
  const auto run_to = [&](double until_s, bool beats) {
    while (servo.deadline_s() < until_s + 1e-9) {
      clock.now = servo.deadline_s();
      if (beats)
        servo.exchange().commands.write(force_x(2, clock.now));
      servo.wake(clock);
    }
    return device.forces.back().x;
  };
  CHECK(run_to(1.0, true) == doctest::Approx(2));
  CHECK(run_to(1.1, false) == doctest::Approx(2).epsilon(1e-9));
  CHECK(run_to(1.125, false) == doctest::Approx(1).epsilon(1e-9));
  CHECK(run_to(1.149, false) > 0);
  CHECK(run_to(1.15, false) == 0.0);
  CHECK(run_to(1.3, false) == 0.0);
  CHECK(run_to(1.325, true) == doctest::Approx(1).epsilon(1e-9));
  CHECK(run_to(1.35, true) == doctest::Approx(2).epsilon(1e-9));
  Event event;
  REQUIRE(servo.exchange().events.pop(event));
  CHECK(event.kind == Event::Kind::kWatchdog);
  CHECK(event.on);
  REQUIRE(servo.exchange().events.pop(event));
  CHECK_FALSE(event.on);
  CHECK(servo.chain().counters.watchdog_trips == 1);
}

TEST_CASE("a late servo does not ramp faster than real time") {
  ClockedServo rig;
  FakeClock& clock = rig.clock;
  Recorder& device = rig.device;
  Servo& servo = rig.servo;
  servo.wake(clock);
  clock.now = 0.125; // one wake-up after 125 ms of silence on both sides
  servo.wake(clock);
  CHECK(device.forces.back().x == doctest::Approx(1).epsilon(1e-9));
}

TEST_CASE("buttons, maps and estimated velocity go through one step") {
  Recorder device;
  device.given.has_velocity = false;
  device.given.position_noise_m = 1e-6;
  Servo servo;
  ServoSettings settings;
  settings.chain.passivity = false;
  settings.map = *AxisMap::parse("zxy", {1, -1, 1});
  servo.exchange().settings.write(settings);
  servo.attach(device);
  Command c;
  c.force_n = {1, 2, 3};
  c.number = 1;
  servo.exchange().commands.write(c);
  for (std::uint64_t k = 0; k < 40; ++k) {
    device.reading.position = {0.001 * static_cast<double>(k), 0, 0}; // 1 m/s along device x
    device.reading.buttons = k < 20 ? 0 : 5;
    servo.step({k, static_cast<double>(k) * 1e-3, 1e-3});
  }
  CHECK(device.forces.back().x == doctest::Approx(-2).epsilon(1e-12));
  CHECK(device.forces.back().y == doctest::Approx(3).epsilon(1e-12));
  CHECK(device.forces.back().z == doctest::Approx(1).epsilon(1e-12));
  REQUIRE(servo.exchange().reports.read());
  const Report& report = servo.exchange().reports.latest();
  CHECK(report.state.velocity.y == doctest::Approx(-1).epsilon(1e-9));
  CHECK(report.state.velocity.x == 0.0);
  Event event;
  REQUIRE(servo.exchange().events.pop(event));
  CHECK((event.number == 0 && event.on));
  CHECK(event.time_s == doctest::Approx(0.02));
  REQUIRE(servo.exchange().events.pop(event));
  CHECK((event.number == 2 && event.on));
  CHECK_FALSE(servo.exchange().events.pop(event));
}

TEST_CASE("a device that falls silent for 20 ms, or says it failed, is stopped until motors on") {
  for (const int how : {0, 1, 2}) {
    CAPTURE(how);
    Recorder device;
    Servo servo;
    ServoSettings settings;
    settings.chain.passivity = false;
    servo.exchange().settings.write(settings);
    servo.attach(device);
    servo.exchange().commands.write(force_x(2, 0));
    std::uint64_t k = 0, number = 1;
    const auto run = [&](int ticks) {
      for (int i = 0; i < ticks; ++i, ++k) {
        const double now = static_cast<double>(k) * 1e-3;
        servo.exchange().commands.write(force_x(2, now, ++number));
        servo.step({k, now, 1e-3});
      }
      return device.forces.back().x;
    };
    CHECK(run(50) == 2.0);
    if (how == 0)
      device.readable = false;
    if (how == 1)
      device.writable = false;
    if (how == 2)
      device.reading.flags |= State::kFault;
    CHECK(run(how == 2 ? 1 : 19) == (how == 2 ? 0.0 : 2.0));
    CHECK(run(3) == 0.0);
    device.readable = device.writable = true;
    device.reading.flags = State::kHomed;
    CHECK(run(100) == 0.0);
    REQUIRE(servo.exchange().reports.read());
    CHECK(servo.exchange().reports.latest().faults == 1);
    CHECK(servo.exchange().reports.latest().fault ==
          (how == 2 ? Fault::kReported : Fault::kSilent));
    servo.attach(device); // opened again: the failure goes on
    CHECK(run(100) == 0.0);
    servo.exchange().motors.enable();
    CHECK(run(1) < 0.1);
    CHECK(run(500) == doctest::Approx(2).epsilon(1e-9));
    REQUIRE(servo.exchange().reports.read());
    CHECK(servo.exchange().reports.latest().fault == Fault::kNone);
  }
}

TEST_CASE("refused and good forces that share a mailbox keep their order") {
  Recorder device;
  Servo servo;
  ServoSettings settings;
  settings.chain.passivity = false;
  servo.exchange().settings.write(settings);
  servo.attach(device);
  std::uint64_t k = 0;
  const auto run = [&](int ticks, Command c) {
    for (int i = 0; i < ticks; ++i, ++k) {
      c.heartbeat_s = static_cast<double>(k) * 1e-3;
      servo.exchange().commands.write(c);
      servo.step({k, c.heartbeat_s, 1e-3});
    }
    return device.forces.back().x;
  };
  Command c = force_x(1, 0);
  CHECK(run(10, c) == 1.0);
  c.force_n.x = 1.5;
  c.number = 2;
  c.refused = 3;
  c.last_refused = true; // a good one, then a bad one
  CHECK(run(12, c) == doctest::Approx(1.5));
  CHECK(servo.chain().refusing);
  CHECK(run(200, c) == 0.0);
  c.number = 3;
  c.refused = 4;
  c.last_refused = false; // a bad one, then a good one
  run(1, c);
  CHECK_FALSE(servo.chain().refusing);
}

// ---- motors and emergency stop are states ---------------------------------------------------

namespace {

/// A servo whose host pushes with 2 N and beats every tick.
struct LoadedServo {
  Recorder device;
  Servo servo;
  std::uint64_t tick = 0, number = 0;

  LoadedServo() {
    ServoSettings settings;
    settings.chain.passivity = false;
    servo.exchange().settings.write(settings);
    servo.attach(device);
  }
  double run(int ticks) {
    for (int i = 0; i < ticks; ++i, ++tick) {
      const double now = static_cast<double>(tick) * 1e-3;
      servo.exchange().commands.write(force_x(2, now, ++number));
      servo.step({tick, now, 1e-3});
    }
    return device.forces.back().x;
  }
  MotorControl& motors() { return servo.exchange().motors; }
};

} // namespace

TEST_CASE("the newest request to the motors wins, however many came before it") {
  LoadedServo rig;
  REQUIRE(rig.run(50) == 2.0);
  SUBCASE("off after many times on, before the first tick") {
    for (int i = 0; i < 1000; ++i)
      rig.motors().enable();
    rig.motors().disable();
    rig.servo.attach(rig.device);
    CHECK(rig.run(1) == 0.0);
    CHECK(rig.run(1000) == 0.0);
  }
  SUBCASE("off after many times on, between two ticks") {
    for (int i = 0; i < 1000; ++i)
      rig.motors().enable();
    rig.motors().disable();
    CHECK(rig.run(1) == 0.0); // the slew limit is 2 N a tick
    CHECK(rig.run(1000) == 0.0);
  }
  SUBCASE("an emergency stop after a thousand resets of the statistics") {
    for (int i = 0; i < 1000; ++i)
      ++rig.servo.exchange().statistics_resets;
    rig.motors().emergency_stop();
    CHECK(rig.run(1) == 0.0);
    CHECK(rig.servo.statistics().ticks == 1);
    CHECK(rig.run(1000) == 0.0);
  }
  SUBCASE("a stop and an enable between two ticks both count") {
    rig.motors().emergency_stop();
    rig.motors().enable();
    CHECK(rig.run(1) < 0.01); // from none, over half a second
    CHECK(rig.run(250) == doctest::Approx(1).epsilon(0.01));
  }
  SUBCASE("an enable before a stop releases nothing") {
    rig.device.reading.flags |= State::kFault;
    rig.run(1);
    rig.device.reading.flags = State::kHomed;
    rig.motors().enable();
    rig.motors().emergency_stop();
    CHECK(rig.run(1000) == 0.0);
    REQUIRE(rig.servo.exchange().reports.read());
    CHECK(rig.servo.exchange().reports.latest().fault == Fault::kReported);
    rig.motors().enable();
    CHECK(rig.run(1000) == doctest::Approx(2));
  }
}

TEST_CASE("the report says what the tick read, wrote and counted, and the state of the motors") {
  LoadedServo rig;
  rig.device.reading.position = {0.01, -0.02, 0.03};
  rig.device.reading.buttons = 5;
  const auto report = [&rig] {
    REQUIRE(rig.servo.exchange().reports.read());
    return rig.servo.exchange().reports.latest();
  };
  rig.run(50);
  Report now = report();
  CHECK(now.tick.index == 49);
  CHECK(now.tick.time_s == doctest::Approx(0.049).scale(0));
  CHECK(now.state.position == rig.device.reading.position);
  CHECK(now.state.buttons == 5);
  CHECK(now.force_n == Vec3{2, 0, 0});
  CHECK(now.counters.ticks == 50);
  CHECK(now.motors);
  CHECK_FALSE(now.latched);
  CHECK(now.fault == Fault::kNone);
  CHECK(now.faults == 0);
  rig.motors().disable();
  rig.run(1);
  CHECK_FALSE(report().motors);
  rig.motors().emergency_stop();
  rig.run(1);
  CHECK(report().latched);
  rig.motors().enable();
  rig.run(1);
  now = report();
  CHECK(now.motors);
  CHECK_FALSE(now.latched);
  // The hand gives way by 1 mm under 1 N of the force that returns: energy that the world gave.
  rig.run(249);
  rig.device.reading.position.x += 1e-3;
  rig.run(1);
  now = report();
  CHECK(now.energy_j == doctest::Approx(-1e-3).epsilon(0.01).scale(0));
  CHECK(now.lowest_energy_j == now.energy_j);
  rig.device.reading.flags |= State::kFault;
  rig.run(1);
  CHECK(report().fault == Fault::kReported);
  CHECK(rig.servo.exchange().reports.latest().faults == 1);
}

TEST_CASE("an emergency stop outlives every new attachment until the motors are enabled") {
  LoadedServo rig;
  REQUIRE(rig.run(50) == 2.0);
  rig.motors().emergency_stop();
  rig.run(1);
  for (int times = 0; times < 3; ++times) {
    rig.servo.detach();
    rig.servo.attach(rig.device);
    CHECK(rig.run(600) == 0.0);
  }
  SUBCASE("a pause does not end it") {
    rig.motors().pause(true);
    rig.run(10);
    rig.motors().pause(false);
    CHECK(rig.run(600) == 0.0);
  }
  SUBCASE("motors off does not end it") {
    rig.motors().disable();
    CHECK(rig.run(600) == 0.0);
  }
  SUBCASE("another servo takes it over") {
    LoadedServo next;
    rig.motors().pause(true); // as the one that ends: the next one is not
    next.motors().take_over(rig.motors());
    next.servo.attach(next.device);
    CHECK(next.run(600) == 0.0);
    next.motors().enable();
    CHECK(next.run(600) == doctest::Approx(2));
    rig.motors().pause(false);
  }
  rig.motors().enable();
  CHECK(rig.run(600) == doctest::Approx(2));
}

TEST_CASE("a pause lets the force fall and rise, and zero_force_confirmed says when it is zero") {
  LoadedServo rig;
  ServoSettings settings;
  settings.chain.passivity = false;
  settings.chain.slew_n_per_s = 100; // 0.1 N a tick
  rig.servo.exchange().settings.write(settings);
  REQUIRE(rig.run(50) == 2.0);
  CHECK_FALSE(rig.motors().zero_force_confirmed());
  rig.motors().pause(true);
  CHECK(rig.run(10) == doctest::Approx(1));
  CHECK_FALSE(rig.motors().zero_force_confirmed());
  CHECK(rig.run(11) == 0.0);
  CHECK(rig.motors().zero_force_confirmed());
  rig.device.writable = false;
  rig.run(1);
  CHECK_FALSE(rig.motors().zero_force_confirmed()); // zero was asked for, but it did not arrive
  rig.device.writable = true;
  rig.motors().pause(false);
  CHECK_FALSE(rig.motors().zero_force_confirmed());
  CHECK(rig.run(600) == doctest::Approx(2));
}

TEST_CASE("the last thing that a released servo writes is zero") {
  LoadedServo rig;
  REQUIRE(rig.run(50) == 2.0);
  CHECK(rig.servo.release());
  CHECK(rig.device.forces.back() == Vec3{});
  CHECK(rig.motors().zero_force_confirmed());
  rig.device.writable = false;
  CHECK_FALSE(rig.servo.release());
}

TEST_CASE("before a device's first reading the force is zero") {
  struct Push final : LocalModel {
    Vec3 force(const Tick&, const State&) noexcept override { return {3, 0, 0}; }
  } push;
  Recorder device;
  device.readable = false;
  device.reading.position = {std::nan(""), 0, 0};
  Servo servo;
  servo.attach(device, &push);
  const auto step = [&](std::uint64_t k) {
    const double time_s = static_cast<double>(k) * 1e-3;
    servo.exchange().commands.write(force_x(2, time_s, k + 1));
    servo.step({k, time_s, 1e-3});
  };
  for (std::uint64_t k = 0; k < 10; ++k) {
    device.readable = k > 4; // then it answers, but with no number
    step(k);
    REQUIRE(device.forces.back() == Vec3{});
  }
  device.reading.position = {};
  for (std::uint64_t k = 10; k < 1000; ++k)
    step(k);
  CHECK(device.forces.back().x == doctest::Approx(5));
}

#include "core/haptic/servo.hpp"
#include "core/haptic/simulated_device.hpp"

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
  CHECK(servo.statistics().lateness.longest_s() == doctest::Approx(0.0035).epsilon(1e-9));
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

TEST_CASE("a host that stops is noticed: half force after 125 ms, none after 150, back in 50") {
  FakeClock clock;
  Recorder device;
  Servo servo;
  ServoSettings settings;
  settings.chain.passivity = false;
  servo.exchange().settings.write(settings);
  servo.attach(device);
  servo.start(clock, 1e-3);
  servo.exchange().commands.write(force_x(2, 0));
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

TEST_CASE("a servo that itself was late does not ramp faster than time") {
  FakeClock clock;
  Recorder device;
  Servo servo;
  ServoSettings settings;
  settings.chain.passivity = false;
  servo.exchange().settings.write(settings);
  servo.attach(device);
  servo.start(clock, 1e-3);
  servo.exchange().commands.write(force_x(2, 0));
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
    std::uint64_t k = 0;
    const auto run = [&](int ticks) {
      for (int i = 0; i < ticks; ++i, ++k) {
        const double now = static_cast<double>(k) * 1e-3;
        servo.exchange().commands.write(force_x(2, now));
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
    servo.exchange().actions.push(Action::kMotorsOn);
    CHECK(run(500) == doctest::Approx(2).epsilon(1e-9));
    Event event;
    REQUIRE(servo.exchange().events.pop(event));
    CHECK(event.kind == Event::Kind::kFault);
    CHECK_FALSE(servo.exchange().events.pop(event));
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

#include "core/haptic/scene/scene_model.hpp"
#include "tests/core/haptic/rig.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string_view>

using namespace tactus::haptic;
using tactus::Vec3;
using test::approx;
using test::Recorder;
using test::without_passivity;

namespace {

struct FakeClock final : Clock {
  double now_s() noexcept override { return now; }
  double now = 0;
};

/// A servo of 1 kHz on an injected clock.
struct ClockedServo {
  FakeClock clock;
  Recorder device;
  Servo servo;
  explicit ClockedServo(double start_s = 0) {
    clock.now = start_s;
    servo.exchange().settings.write({without_passivity(), {}});
    servo.attach(device);
    servo.start(clock, 1e-3);
  }
  void ask(double force_n) {
    servo.exchange().commands.write({{force_n, 0, 0}, 1, 0, false, clock.now});
  }
  void wake(double late_s = 0) {
    clock.now = servo.deadline_s() + late_s;
    servo.wake(clock);
  }
};

/// A servo whose host pushes with 2 N.
struct LoadedServo : test::HostedServo<Recorder> {
  LoadedServo() : HostedServo(without_passivity()) { attach(); }
  double run(int ticks) {
    HostedServo::run(ticks, {2, 0, 0});
    return device.forces.back().x;
  }
  MotorControl& motors() { return servo.exchange().motors; }
};

} // namespace

TEST_CASE("a wake-up 3.5 ms late runs its tick once, skips three grid points and keeps the phase") {
  ClockedServo rig(10);
  for (int k = 0; k < 5; ++k)
    rig.wake();
  CHECK(rig.servo.deadline_s() == approx(10.005).epsilon(1e-12));
  rig.wake(0.0035);
  CHECK(rig.device.ticks.size() == 6);
  CHECK(rig.device.ticks.back().index == 8);
  CHECK(rig.device.ticks.back().time_s == rig.clock.now);
  const ServoStatistics& statistics = rig.servo.statistics();
  CHECK(statistics.skipped == 3);
  CHECK(statistics.overruns == 1);
  CHECK(statistics.ticks == 6);
  CHECK(statistics.lateness.max_s() == approx(0.0035).epsilon(1e-9));
  CHECK(rig.servo.deadline_s() == approx(10.009).epsilon(1e-12));
  rig.wake(0.0004);
  CHECK(statistics.skipped == 3);
  CHECK(rig.device.ticks.back().index == 9);
}

TEST_CASE("after the host stops the force is half at 125 ms, zero at 150 ms, and back in 50 ms") {
  ClockedServo rig;
  const auto run_to = [&](double until_s, bool beats) {
    while (rig.servo.deadline_s() < until_s + 1e-9) {
      rig.clock.now = rig.servo.deadline_s();
      if (beats)
        rig.ask(2);
      rig.wake();
    }
    return rig.device.forces.back().x;
  };
  CHECK(run_to(1.0, true) == approx(2));
  CHECK(run_to(1.1, false) == approx(2).epsilon(1e-9));
  CHECK(run_to(1.125, false) == approx(1).epsilon(1e-9));
  CHECK(run_to(1.149, false) > 0);
  CHECK(run_to(1.15, false) == 0.0);
  CHECK(run_to(1.3, false) == 0.0);
  CHECK(run_to(1.325, true) == approx(1).epsilon(1e-9));
  CHECK(run_to(1.35, true) == approx(2).epsilon(1e-9));
  for (const bool on : {true, false}) {
    ServoEvent event;
    REQUIRE(rig.servo.exchange().events.pop(event));
    CHECK(std::get<WatchdogEvent>(event).on == on);
  }
  CHECK(rig.servo.chain().counters.watchdog_trips == 1);
}

TEST_CASE("a late servo does not ramp faster than real time") {
  ClockedServo rig;
  rig.ask(2);
  rig.wake();
  rig.clock.now = 0.125; // one wake-up after 125 ms of silence on both sides
  rig.servo.wake(rig.clock);
  CHECK(rig.device.forces.back().x == approx(1).epsilon(1e-9));
}

TEST_CASE("buttons, maps and estimated velocity go through one step") {
  test::HostedServo<Recorder> rig;
  rig.device.given.has_velocity = false;
  rig.device.given.position_noise_m = 1e-6;
  rig.servo.exchange().settings.write({without_passivity(), *AxisMap::parse("zxy", {1, -1, 1})});
  rig.attach();
  for (int k = 0; k < 40; ++k) {
    rig.device.reading.position = {0.001 * k, 0, 0}; // 1 m/s along device x
    rig.device.reading.buttons = k < 20 ? 0 : 5;
    rig.step({1, 2, 3});
  }
  CHECK(norm(rig.device.forces.back() - Vec3{-2, 3, 1}) < 1e-12);
  CHECK(norm(rig.report().state.velocity - Vec3{0, -1, 0}) < 1e-9);
  ServoEvent event;
  for (const int number : {0, 2}) {
    REQUIRE(rig.servo.exchange().events.pop(event));
    const auto& button = std::get<ButtonEvent>(event);
    CHECK((button.number == number && button.on));
    CHECK(button.time_s == approx(0.02));
  }
  CHECK_FALSE(rig.servo.exchange().events.pop(event));
}

TEST_CASE("a device that falls silent for 20 ms, or says it failed, is stopped until motors on") {
  enum class How { kUnreadable, kUnwritable, kFault };
  for (const How how : {How::kUnreadable, How::kUnwritable, How::kFault}) {
    CAPTURE(static_cast<int>(how));
    LoadedServo rig;
    CHECK(rig.run(50) == 2.0);
    rig.device.readable = how != How::kUnreadable;
    rig.device.writable = how != How::kUnwritable;
    if (how == How::kFault) {
      rig.device.reading.flags |= State::kFault;
      CHECK(rig.run(1) == 0.0);
    } else {
      CHECK(rig.run(19) == 2.0);
    }
    CHECK(rig.run(3) == 0.0);
    rig.device.readable = rig.device.writable = true;
    rig.device.reading.flags = State::kHomed;
    CHECK(rig.run(100) == 0.0);
    CHECK(rig.report().faults == 1);
    CHECK(rig.report().fault == (how == How::kFault ? Fault::kReported : Fault::kSilent));
    rig.attach(); // opened again: the failure goes on
    CHECK(rig.run(100) == 0.0);
    rig.motors().enable();
    CHECK(rig.run(1) < 0.1);
    CHECK(rig.run(500) == approx(2).epsilon(1e-9));
    CHECK(rig.report().fault == Fault::kNone);
  }
}

TEST_CASE("refused and good forces that share a mailbox keep their order") {
  test::HostedServo<Recorder> rig(without_passivity());
  rig.attach();
  const auto run = [&rig](int ticks, Command command) {
    for (; ticks > 0; --ticks) {
      command.heartbeat_s = static_cast<double>(rig.tick) * 1e-3;
      rig.servo.exchange().commands.write(command);
      rig.servo.step({rig.tick++, command.heartbeat_s, 1e-3});
    }
    return rig.device.forces.back().x;
  };
  CHECK(run(10, {{1, 0, 0}, 1}) == 1.0);
  CHECK(run(12, {{1.5, 0, 0}, 2, 3, true}) == approx(1.5)); // a good one, then a bad one
  CHECK(rig.servo.chain().refusing);
  CHECK(run(200, {{1.5, 0, 0}, 2, 3, true}) == 0.0);
  run(1, {{1.5, 0, 0}, 3, 4, false}); // a bad one, then a good one
  CHECK_FALSE(rig.servo.chain().refusing);
}

TEST_CASE("the newest request to the motors wins, however many came before it") {
  LoadedServo rig;
  REQUIRE(rig.run(50) == 2.0);
  for (int i = 0; i < 1000; ++i)
    rig.motors().enable();
  SUBCASE("off after many times on, before the first tick") {
    rig.motors().disable();
    rig.attach();
    CHECK(rig.run(1) == 0.0);
    CHECK(rig.run(1000) == 0.0);
  }
  SUBCASE("off after many times on, between two ticks") {
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
    CHECK(rig.run(250) == approx(1).epsilon(0.01));
  }
  SUBCASE("an enable before a stop releases nothing") {
    rig.device.reading.flags |= State::kFault;
    rig.run(1);
    rig.device.reading.flags = State::kHomed;
    rig.motors().enable();
    rig.motors().emergency_stop();
    CHECK(rig.run(1000) == 0.0);
    CHECK(rig.report().fault == Fault::kReported);
    rig.motors().enable();
    CHECK(rig.run(1000) == approx(2));
  }
}

TEST_CASE("the report says what the tick read, wrote and counted, and the state of the motors") {
  LoadedServo rig;
  rig.device.reading.position = {0.01, -0.02, 0.03};
  rig.device.reading.buttons = 5;
  const auto after = [&rig](int ticks) {
    rig.run(ticks);
    return rig.report();
  };
  Report now = after(50);
  CHECK(now.tick.index == 49);
  CHECK(now.tick.time_s == approx(0.049));
  CHECK(now.state.position == rig.device.reading.position);
  CHECK(now.state.buttons == 5);
  CHECK(now.force_n == Vec3{2, 0, 0});
  CHECK(now.counters.ticks == 50);
  CHECK(now.motors);
  CHECK_FALSE(now.latched);
  CHECK(now.fault == Fault::kNone);
  CHECK(now.faults == 0);
  rig.motors().disable();
  CHECK_FALSE(after(1).motors);
  rig.motors().emergency_stop();
  CHECK(after(1).latched);
  rig.motors().enable();
  now = after(1);
  CHECK(now.motors);
  CHECK_FALSE(now.latched);
  // The hand gives way by 1 mm under 1 N of a contact: energy that the world gave.
  struct Contact final : LocalModel {
    Vec3 force(const Tick&, const State&) noexcept override { return {1, 0, 0}; }
  } contact;
  rig.attach(&contact); // the statistics go on until they are reset
  rig.run(50);
  CHECK(rig.report().counters.ticks == now.counters.ticks + 50);
  rig.device.reading.position.x += 1e-3;
  now = after(1);
  CHECK(now.energy_j == approx(-1e-3).epsilon(0.01));
  CHECK(now.lowest_energy_j == now.energy_j);
}

TEST_CASE("an emergency stop outlives every new attachment until the motors are enabled") {
  LoadedServo rig;
  REQUIRE(rig.run(50) == 2.0);
  rig.motors().emergency_stop();
  rig.run(1);
  for (int times = 0; times < 3; ++times) {
    rig.servo.detach();
    rig.attach();
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
    next.attach();
    CHECK(next.run(600) == 0.0);
    next.motors().enable();
    CHECK(next.run(600) == approx(2));
    rig.motors().pause(false);
  }
  rig.motors().enable();
  CHECK(rig.run(600) == approx(2));
}

TEST_CASE("a pause lets the force fall and rise, and zero_force_confirmed says when it is zero") {
  LoadedServo rig;
  ChainSettings settings = without_passivity();
  settings.slew_n_per_s = 100; // 0.1 N a tick
  rig.set(settings);
  REQUIRE(rig.run(50) == 2.0);
  CHECK_FALSE(rig.motors().zero_force_confirmed());
  rig.motors().pause(true);
  CHECK(rig.run(10) == approx(1));
  CHECK_FALSE(rig.motors().zero_force_confirmed());
  CHECK(rig.run(11) == 0.0);
  CHECK(rig.motors().zero_force_confirmed());
  rig.device.writable = false;
  rig.run(1);
  CHECK_FALSE(rig.motors().zero_force_confirmed()); // zero was asked for, but it did not arrive
  rig.device.writable = true;
  rig.motors().pause(false);
  CHECK_FALSE(rig.motors().zero_force_confirmed());
  CHECK(rig.run(600) == approx(2));
  // The last thing that a released servo writes is zero.
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
  test::HostedServo<Recorder> rig;
  rig.device.readable = false;
  rig.device.reading.position = {std::nan(""), 0, 0};
  rig.attach(&push);
  for (int tick = 0; tick < 10; ++tick) {
    rig.device.readable = tick > 4; // then it answers, but with no number
    rig.step({2, 0, 0});
    REQUIRE(rig.device.forces.back() == Vec3{});
  }
  rig.device.reading.position = {};
  rig.run(990, {2, 0, 0});
  CHECK(rig.device.forces.back().x == approx(5));
}

TEST_CASE("an unreachable position becomes the last good one and is flagged") {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  Vec3 last_good{};
  const auto flags = [&](const Vec3& position) {
    State state;
    state.position = position;
    state.velocity = {1, 1, 1};
    reject_unreachable({}, state, last_good); // 50 mm either way: 87 mm to a corner
    CHECK(state.position == last_good);
    return state.flags;
  };
  CHECK(flags({0.01, 0.02, 0.03}) == State::kHomed);
  CHECK(flags({0.34, 0, 0}) == State::kHomed); // outside of the box, within reach
  for (const Vec3& wrong : {Vec3{std::nan(""), 0, 0}, Vec3{0, kInfinite, 0}, Vec3{0, 0, -kInfinite},
                            Vec3{0.36, 0, 0}, Vec3{1e300, 1e300, 1e300}}) {
    CHECK(flags(wrong) == (State::kHomed | State::kUnreachable));
    CHECK(last_good == Vec3{0.34, 0, 0});
  }
}

TEST_CASE(
    "an unreachable reading takes the force away at that tick; it returns over the enable time") {
  LoadedServo rig;
  CHECK(rig.run(1000) == 2);
  rig.device.reading.flags |= State::kUnreachable;
  CHECK(rig.run(1) == 0);
  CHECK(rig.run(10) == 0);
  rig.device.reading.flags = State::kHomed;
  CHECK(rig.run(1) < 0.05);
  CHECK(rig.run(250) == approx(1).epsilon(0.02));
  CHECK(rig.run(300) == approx(2));
}

TEST_CASE("a device that finds its origin leaps without a hit, a velocity or a kick") {
  for (const int early_ticks : {0, 40}) // between the leap and the report that it is calibrated
    for (const std::uint32_t before : {0u, State::kHomed | State::kUnreachable}) {
      CAPTURE(early_ticks);
      CAPTURE(before);
      SceneModel scene;
      auto floor = std::make_unique<Scene>();
      floor->bodies.resize(1);
      floor->bodies[0].key = 1;
      floor->bodies[0].shape = Plane{};
      scene.publish(std::move(floor));
      test::HostedServo<Recorder> rig(without_passivity());
      rig.device.reading.flags = before;
      rig.device.reading.position = {0, 0.05, 0.05};
      rig.attach(&scene);
      rig.run(100, {2, 0, 0});
      rig.device.reading.position = {0, 0.05, -0.05}; // 100 mm, into the floor
      rig.run(early_ticks, {2, 0, 0});
      CHECK(rig.device.forces.back() == Vec3{});
      rig.device.reading.flags = State::kHomed;
      double last_n = 0, largest_rise_n = 0;
      for (int tick = 0; tick < 600; ++tick) {
        rig.step({2, 0, 0});
        CHECK(rig.report().state.velocity == Vec3{});
        const double force_n = norm(rig.device.forces.back());
        largest_rise_n = std::max(largest_rise_n, force_n - last_n);
        last_n = force_n;
      }
      CHECK(largest_rise_n < 2 * 8e-3 / 0.5); // the limit over the enable time, and some
      CHECK(rig.device.forces.back().x > 1.9);
      SceneEvent event;
      while (scene.events().pop(event))
        CHECK(!std::holds_alternative<HitEvent>(event));
    }
}

TEST_CASE("a rotation goes through the map as an axial vector") {
  test::HostedServo<Recorder> rig;
  rig.device.reading.rotation = {0.1, 0.2, 0.3};
  rig.attach();
  const auto read = [&](std::string_view axes, const std::array<double, 3>& signs) {
    ServoSettings settings;
    settings.map = AxisMap::parse(axes, signs).value();
    rig.servo.exchange().settings.write(settings);
    rig.step({});
    return rig.report().state.rotation;
  };
  CHECK(read("xyz", {-1, 1, 1}) == Vec3{0.1, -0.2, -0.3}); // a mirror across x
  CHECK(read("yzx", {1, 1, 1}) == Vec3{0.2, 0.3, 0.1});
  CHECK(read("xyz", {-1, -1, 1}) == Vec3{-0.1, -0.2, 0.3});
}

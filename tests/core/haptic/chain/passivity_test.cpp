#include "tests/core/haptic/chain/sampled_wall.hpp"
#include "tests/core/haptic/rig.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <numbers>

// The controller in a loop with walls and hands; passivity_law_test.cpp has its equations.

using namespace tactus::haptic;
using namespace tactus::haptic::test;
using tactus::Vec3;
using Scene = WallCase::Scene;
using Velocity = WallCase::Velocity;

namespace {

/// Exact readings without latency, and neither slew limit nor tank to hide the controller.
WallCase ideal(double stiffness_n_per_m, Scene scene, double value) {
  WallCase c;
  c.stiffness_n_per_m = stiffness_n_per_m;
  c.scene = scene;
  c.value = value;
  c.declared = true;
  c.slew_n_per_s = 1e9;
  c.tank_j = 1e6;
  return c;
}

struct Flight {
  double exit_speed; ///< over that of the arrival
  double lowest_j, after_ten_ticks_j;
};

Flight fly(double stiffness_n_per_m, bool passivity) {
  WallRig rig(ideal(stiffness_n_per_m, Scene::kFlight, 0.2), passivity);
  const double exit_energy = rig.measure(2).exit_energy;
  for (int tick = 0; tick < 10; ++tick)
    rig.tick();
  return {std::sqrt(exit_energy), rig.chain().lowest_energy_j, rig.chain().energy_j};
}

} // namespace

TEST_CASE("a handle that flies into a wall five times too stiff does not come out faster") {
  CHECK(fly(5000, false).exit_speed >= 1.10);
  const Flight on = fly(5000, true);
  CHECK(on.exit_speed <= 1.005);
  CHECK(on.after_ten_ticks_j >= -1e-9);
}

TEST_CASE("in a soft wall, too, the controller removes the energy of the zero-order hold") {
  const Flight off = fly(500, false), on = fly(500, true);
  CHECK(on.exit_speed < off.exit_speed);
  CHECK(off.lowest_j < -5e-5);
  CHECK(on.after_ten_ticks_j >= -1e-9);
}

TEST_CASE("pushed at a wall beyond Colgate's limit a handle cycles less with the controller, and "
          "within the limit it rests at F/K") {
  const auto push = [](double stiffness, bool passivity) {
    return run_wall(ideal(stiffness, Scene::kPush, 1), passivity, 4);
  };
  CHECK(push(5000, false).motion_m > 5e-3);
  CHECK(push(5000, true).motion_m < 1.5e-3);
  const WallResult off = push(500, false), on = push(500, true);
  CHECK(off.middle_m == approx(2e-3).epsilon(0.01));
  CHECK(on.middle_m == approx(2e-3).epsilon(0.01));
  CHECK(on.motion_m <= off.motion_m);
  // With 4 N s/m of damping the limit is 2 (0.5 + 4)/1 ms = 9000 N/m.
  WallCase damped = ideal(5000, Scene::kPush, 1);
  damped.damping_n_s_per_m = 4;
  const WallResult rests = run_wall(damped, false, 4);
  CHECK(rests.motion_m < 1e-6);
  CHECK(rests.middle_m == approx(1.0 / 5000).epsilon(1e-3));
}

TEST_CASE("Colgate's bound K < 2(B + b)/T separates decay from growth") {
  // At T = 1 ms and B = 0.5 Ns/m the bound is 1000 N/m. A handle that never leaves the wall (here
  // a spring about zero) swings down below the bound and up above it.
  struct Spring final : LocalModel {
    Vec3 force(const Tick&, const State& s) noexcept override { return s.position * -stiffness; }
    double stiffness = 0;
  };
  for (const double stiffness : {700.0, 1300.0}) {
    HostedServo<SimulatedDevice> rig(without_passivity());
    SimulatedDevice::Settings settings;
    settings.hand.hold = HandSettings::Hold::kFree;
    rig.device.set(settings);
    rig.device.set_state({1e-3, 0, 0}, {});
    Spring spring;
    spring.stiffness = stiffness;
    rig.attach(&spring);
    const auto largest = [&rig] {
      double x = 0;
      for (int n = 0; n < 1000; ++n) {
        rig.step({});
        x = std::max(x, std::abs(rig.device.position().x));
      }
      return x;
    };
    const double early = largest();
    static_cast<void>(largest());
    CAPTURE(stiffness);
    CHECK((largest() > early) == (stiffness > 1000));
  }
}

TEST_CASE("guidance by a patch reaches the hand, with an allowance and without") {
  // 1 N on a hand of 200 N/m: 5 mm at rest. A damper without a bound held the handle at 0.08 um.
  for (const double allowance_w : {0.0, 0.05}) {
    ChainSettings settings;
    settings.allowance_w = allowance_w;
    HostedServo<SimulatedDevice> rig(settings);
    rig.attach();
    rig.run(100, {});
    rig.run(2900, {1, 0, 0});
    CHECK(rig.device.position().x == approx(5e-3).epsilon(1e-3));
  }
}

TEST_CASE("a stiff wall that a patch renders a tick late is bounded with the default allowance") {
  WallCase c;
  c.stiffness_n_per_m = 2000;
  c.declared = c.by_patch = true;
  const double off = run_wall(c, false, 4).motion_m, strict = run_wall(c, true, 4).motion_m;
  c.allowance_w = 0.05;
  CHECK(strict < off);
  CHECK(run_wall(c, true, 4).motion_m < off);
}

namespace {

/// Force rms with the controller over that without, where this is quiet; the energy of a flight;
/// and the force, which never points into the wall nor acts outside it.
void check_not_worse(const WallCase& c) {
  const WallResult off = run_wall(c, false), on = run_wall(c, true);
  CAPTURE(c.stiffness_n_per_m);
  CAPTURE(c.rate_hz);
  CAPTURE(c.encoder_m);
  CAPTURE(c.latency_ticks);
  CAPTURE(static_cast<int>(c.velocity));
  CAPTURE(static_cast<int>(c.scene));
  CAPTURE(c.value);
  CHECK(on.max_slew <= 1 + 1e-9);
  CHECK(on.max_force_n <= c.force_limit_n * (1 + 1e-12));
  CHECK(on.max_pull_n <= 1e-12);
  if (c.scene == Scene::kFlight) {
    CHECK(on.left == off.left);
    CHECK(on.exit_energy <= 1.005);
  } else if (off.stable()) {
    // less than one step of the encoder makes is rest
    CHECK(on.force_rms_n <=
          std::max({1.1 * off.force_rms_n, 2e-3, c.stiffness_n_per_m * c.encoder_m}));
  }
}

using List = std::initializer_list<double>;

void check_walls(List stiffnesses, List rates, List encoders, std::initializer_list<Velocity> how,
                 std::initializer_list<int> latencies) {
  for (const int latency : latencies)
    for (const double k : stiffnesses)
      for (const double rate : rates)
        for (const double encoder : encoders)
          for (const Velocity velocity : how) {
            WallCase c;
            c.latency_ticks = latency;
            c.declared = true;
            c.stiffness_n_per_m = k;
            c.rate_hz = rate;
            c.encoder_m = encoder;
            c.velocity = velocity;
            const auto check = [&c](Scene scene, double value) {
              c.scene = scene;
              c.value = value;
              check_not_worse(c);
            };
            check(Scene::kFlight, 0.05);
            check(Scene::kFlight, 0.2);
            check(Scene::kFlight, 0.5);
            check(Scene::kPush, 1);
            check(Scene::kSpring, 5e-3);
            check(Scene::kPerson, 2e-3);
            check(Scene::kStroke, 5e-3);
          }
}

} // namespace

TEST_CASE("the controller does not oscillate where the wall is stable without it") {
  // What an unbounded damper, after the slew limit, made of three harmless walls: 4.74 N rms
  // against 0.04, 5.6 mm against 0.06, 2.5 mm against 0.04.
  WallCase person;
  person.stiffness_n_per_m = 300;
  person.encoder_m = 3.4e-5;
  person.velocity = Velocity::kEstimated;
  person.scene = Scene::kPerson;
  person.value = 5e-4;
  WallCase loose_grip = person;
  loose_grip.stiffness_n_per_m = 500;
  loose_grip.scene = Scene::kSpring;
  loose_grip.hand_n_per_m = 50;
  loose_grip.hand_n_s_per_m = 0.5;
  loose_grip.value = 5e-3;
  WallCase pushed;
  pushed.stiffness_n_per_m = 200;
  for (const WallCase& c : {person, loose_grip, pushed}) {
    check_not_worse(c);
    CHECK(run_wall(c, true, 4).motion_m <= std::max(1.1 * run_wall(c, false, 4).motion_m, 2e-5));
  }
}

TEST_CASE("over walls, velocities and hands the controller makes nothing worse") {
  check_walls({300, 4000}, {500}, {0, 1e-4}, {Velocity::kEstimated}, {0, 1});
  check_walls({1000}, {1000}, {0}, {Velocity::kIdeal, Velocity::kNoisy}, {0});
}

TEST_CASE("over walls, rates, encoders, velocities and hands the controller makes nothing worse" *
          doctest::test_suite("slow")) { // bench/haptic_passivity is the whole sweep
  check_walls({50, 300, 1000, 4000}, {500, 1000, 4000}, {0, 3.4e-5, 1e-4},
              {Velocity::kIdeal, Velocity::kEstimated, Velocity::kNoisy, Velocity::kDifference},
              {0, 1});
}

TEST_CASE("latency makes a wall no noisier with the controller, whether it is declared or not") {
  for (const bool declared : {false, true})
    for (const int latency : {1, 3})
      for (const double k : {50.0, 1000.0})
        for (const Scene scene : {Scene::kSpring, Scene::kPerson}) {
          WallCase c;
          c.stiffness_n_per_m = k;
          c.encoder_m = 3.4e-5;
          c.velocity = Velocity::kEstimated;
          c.latency_ticks = latency;
          c.declared = declared;
          c.scene = scene;
          c.value = 2e-3;
          check_not_worse(c);
        }
  // Pressed hard, near the edge of stability, where a contact that is lowered late would hum.
  WallCase c;
  c.stiffness_n_per_m = 300;
  c.rate_hz = 500;
  c.latency_ticks = 3;
  c.scene = Scene::kSpring;
  c.hand_n_per_m = 1000;
  c.value = 5e-3;
  check_not_worse(c);
}

TEST_CASE("the latency that the device declares, or one tick, counts in the energy of a flight") {
  // The observer sees the energy that latency creates only where it knows which force was felt
  // when.
  for (const int latency : {0, 1, 2, 3})
    for (const double k : {200.0, 500.0, 1000.0, 2000.0}) {
      WallCase c;
      c.stiffness_n_per_m = k;
      c.scene = Scene::kFlight;
      c.value = 0.2;
      c.latency_ticks = latency;
      CAPTURE(latency);
      CAPTURE(k);
      if (latency <= 1)
        CHECK(run_wall(c, true).exit_energy <= 1.005);
      if (latency == 3)
        CHECK(run_wall(c, false).exit_energy > 1.1);
      c.declared = true;
      const double exit_energy = run_wall(c, true).exit_energy;
      CHECK(exit_energy <= 1.005);
      // A limit on what a contact may release must not take the bounce from a wall that friction
      // holds: the damped half swing leaves exp(-2 pi z/sqrt(1 - z^2)) of the energy, with the
      // handle's 0.1 kg and 0.5 N s/m.
      const double z = 0.5 / (2 * std::sqrt(k * 0.1));
      if (latency == 0 && k == 200)
        CHECK(exit_energy ==
              approx(std::exp(-2 * std::numbers::pi * z / std::sqrt(1 - z * z))).epsilon(0.1));
    }
}

TEST_CASE(
    "the chain takes from a contact no more than its share, and brakes with the motors' gain") {
  ChainSettings settings;
  settings.slew_n_per_s = 1e9;
  settings.force_limit_n = 2;
  settings.device.latency_ticks = 0;
  ChainState state;
  double x = 0, t = 0;
  const auto tick = [&](double velocity, const Vec3& local) {
    x += velocity * 1e-3;
    ChainInput input;
    input.time_s = input.heartbeat_s = t += 1e-3;
    input.position = {x, 0, 0};
    input.velocity = {velocity, 0, 0};
    input.local_force = local;
    return step(state, settings, input).x;
  };
  // The patch asks for 20 N and the contact for 20 N; 2 N are written, of which 1 N is the
  // contact's. Thrown back with nothing left, the contact's 1 N goes and the patch's stays.
  command(state, settings, {-20, 0, 0}, 0);
  settings.device.damping_limit_n_s_per_m = 1e-9;
  tick(0.3, {-20, 0, 0});
  double force = 0;
  for (int n = 0; n < 20; ++n)
    force = tick(-0.3, {-20, 0, 0});
  CHECK(state.energy_j < 0);
  CHECK(force == approx(-1));
  // Without motors there is no brake either, whatever the debt.
  motors(state, false);
  for (int n = 0; n < 10; ++n)
    CHECK(tick(-0.3, {-20 - 1e3 * x, 0, 0}) == 0);
}

TEST_CASE("a handle pushed at a wall that is too stiff and felt too late bounces less with the "
          "controller, at no larger force rms over many bounces") {
  // Without it the handle flies 70 to 95 mm, and in half a second it meets the wall twice or
  // thrice: the rms counts its returns. Over many the mean force is the push, since the handle
  // stays, and of a force between 0 and F_max with that mean the rms is at most sqrt(F (F_max -
  // F)).
  constexpr double kPush_n = 1, kSeconds = 20;
  for (const double stiffness : {3000.0, 4000.0})
    for (const bool declared : {false, true})
      for (const double encoder_m : {0.0, 3.4e-5}) {
        WallCase c;
        c.stiffness_n_per_m = stiffness;
        c.encoder_m = encoder_m;
        c.latency_ticks = stiffness < 4000 ? 3 : 2;
        c.declared = declared;
        c.value = kPush_n;
        const WallResult off = run_wall(c, false, kSeconds), on = run_wall(c, true, kSeconds);
        CAPTURE(stiffness);
        CAPTURE(declared);
        CAPTURE(encoder_m);
        CHECK(on.force_rms_n <= off.force_rms_n);
        CHECK(on.motion_m <= 0.6 * off.motion_m);
        const double bound_n = std::sqrt(kPush_n * (c.force_limit_n - kPush_n));
        CHECK(off.force_rms_n <= bound_n);
        CHECK(off.force_rms_n >= 0.9 * bound_n);
      }
}

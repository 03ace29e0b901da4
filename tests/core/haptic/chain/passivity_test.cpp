#include "tests/core/haptic/approx.hpp"
#include "tests/core/haptic/chain/sampled_wall.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <vector>

using namespace tactus::haptic;
using namespace tactus::haptic::test;

namespace {

/// The simulated handle with a person who pushes with a constant force besides.
struct LoadedDevice final : Backend {
  std::string open() override { return {}; }
  void close() noexcept override {}
  Caps caps() const noexcept override { return device.caps(); }
  bool read(const Tick& tick, State& state) noexcept override { return device.read(tick, state); }
  bool write(const Vec3& force) noexcept override { return device.write(force + push); }
  SimulatedDevice device;
  Vec3 push;
};

struct Rig {
  Rig(double stiffness, bool observer, double limit_n = 8) : wall(stiffness) {
    SimulatedDevice::Settings settings;
    settings.hand.hold = HandSettings::Hold::kFree;
    settings.stops = false;
    device.device.set(settings);
    ServoSettings servo_settings;
    servo_settings.chain.passivity = observer;
    servo_settings.chain.slew_n_per_s = 1e9;
    servo_settings.chain.force_limit_n = limit_n;
    servo_settings.chain.tank_j = 1e6;
    servo.exchange().settings.write(servo_settings);
    servo.attach(device, &wall);
  }
  void tick() {
    servo.step({index, static_cast<double>(index) * 1e-3, 1e-3});
    ++index;
  }
  [[nodiscard]] double x() const { return device.device.position().x; }
  [[nodiscard]] double v() const { return device.device.velocity().x; }

  SampledWall wall;
  LoadedDevice device;
  Servo servo;
  std::uint64_t index = 0;
};

struct Flight {
  double arrival = 0, exit = 0, after_ten = 0, energy_after_ten = 0, lowest = 0;
};

Flight fly(double stiffness, bool observer) {
  Rig rig(stiffness, observer);
  rig.device.device.set_state({-0.01, 0, 0}, {0.2, 0, 0});
  Flight flight;
  bool inside = false;
  int since_exit = -1;
  for (int n = 0; n < 2000 && since_exit < 10; ++n) {
    const double before = rig.v();
    rig.tick();
    if (since_exit >= 0)
      ++since_exit;
    if (!inside && rig.x() > 0) {
      flight.arrival = before;
      inside = true;
    }
    if (inside && since_exit < 0 && rig.x() <= 0) {
      flight.exit = -rig.v();
      since_exit = 0;
    }
  }
  flight.after_ten = -rig.v();
  flight.energy_after_ten = rig.servo.chain().energy_j;
  flight.lowest = rig.servo.chain().lowest_energy_j;
  return flight;
}

struct Push {
  double peak_to_peak_m = 0, fastest = 0, middle_m = 0, energy = 0, lowest = 0;
};

Push push(double stiffness, bool observer) {
  Rig rig(stiffness, observer);
  rig.device.push = {1, 0, 0};
  rig.device.device.set_state({-0.002, 0, 0}, {});
  double low = 1, high = -1;
  Push result;
  for (int n = 0; n < 4000; ++n) {
    rig.tick();
    if (n < 3000)
      continue;
    low = std::min(low, rig.x());
    high = std::max(high, rig.x());
    result.fastest = std::max(result.fastest, std::abs(rig.v()));
  }
  result.peak_to_peak_m = high - low;
  result.middle_m = 0.5 * (high + low);
  result.energy = rig.servo.chain().energy_j;
  result.lowest = rig.servo.chain().lowest_energy_j;
  return result;
}

} // namespace

TEST_CASE("a handle that flies into a wall five times too stiff does not come out faster") {
  const Flight off = fly(5000, false), on = fly(5000, true);
  MESSAGE("K 5000, arrival " << off.arrival << " m/s; observer off: exit " << off.exit << " m/s, E "
                             << off.lowest << " J; on: exit " << on.exit << ", ten ticks later "
                             << on.after_ten << ", lowest E " << on.lowest << ", E then "
                             << on.energy_after_ten);
  CHECK(off.exit >= 1.10 * off.arrival);
  CHECK(on.exit <= 1.005 * on.arrival);
  CHECK(on.energy_after_ten >= -1e-9);
}

TEST_CASE("in a soft wall, too, the controller removes the energy of the zero-order hold") {
  const Flight off = fly(500, false), on = fly(500, true);
  MESSAGE("K 500, arrival " << off.arrival << "; off: exit " << off.exit << ", E " << off.lowest
                            << "; on: exit " << on.exit << ", lowest E " << on.lowest);
  CHECK(on.exit < off.exit);
  CHECK(off.lowest < -5e-5);
  CHECK(on.energy_after_ten >= -1e-9);
}

TEST_CASE("a constant push on a wall five times too stiff: the observer shrinks the limit cycle") {
  const Push off = push(5000, false), on = push(5000, true);
  MESSAGE("K 5000, push 1 N, last second: off p-p "
          << off.peak_to_peak_m * 1e3 << " mm, " << off.fastest << " m/s, E " << off.energy
          << "; on p-p " << on.peak_to_peak_m * 1e3 << " mm, " << on.fastest << " m/s, lowest E "
          << on.lowest);
  CHECK(off.peak_to_peak_m > 5e-3);
  CHECK(on.peak_to_peak_m < 1.5e-3);
}

TEST_CASE("a constant push on a wall within Colgate's limit converges to F/K") {
  const Push off = push(500, false), on = push(500, true);
  MESSAGE("K 500: off p-p " << off.peak_to_peak_m * 1e3 << " mm about " << off.middle_m * 1e3
                            << "; on " << on.peak_to_peak_m * 1e3 << " about "
                            << on.middle_m * 1e3);
  CHECK(off.middle_m == approx(2e-3).epsilon(0.01));
  CHECK(on.middle_m == approx(2e-3).epsilon(0.01));
  CHECK(on.peak_to_peak_m <= off.peak_to_peak_m);
}

TEST_CASE("Colgate's bound K < 2(B + b)/T separates decay from growth") {
  // At T = 1 ms and B = 0.5 Ns/m the bound is 1000 N/m. A handle that never leaves the wall (here
  // a spring about zero) swings down below the bound and up above it.
  struct Spring final : LocalModel {
    explicit Spring(double k) : stiffness(k) {}
    Vec3 force(const Tick&, const State& s) noexcept override { return s.position * -stiffness; }
    double stiffness;
  };
  for (const double stiffness : {700.0, 1300.0}) {
    Rig rig(0, false);
    Spring spring(stiffness);
    rig.servo.attach(rig.device, &spring);
    rig.device.device.set_state({1e-3, 0, 0}, {});
    double early = 0, late = 0;
    for (int n = 0; n < 3000; ++n) {
      rig.tick();
      (n < 1000 ? early : late) = std::max(n < 1000 ? early : late, std::abs(rig.x()));
      if (n == 1999)
        late = 0;
    }
    CAPTURE(stiffness);
    CHECK((late > early) == (stiffness > 1000));
  }
}

TEST_CASE("more damping raises the stable stiffness") {
  // With damp 4 the bound is 2(0.5 + 4)/1 ms = 9000 N/m, so 5000 N/m rests.
  Rig rig(5000, false);
  ServoSettings settings;
  settings.chain.passivity = false;
  settings.chain.slew_n_per_s = 1e9;
  settings.chain.force_limit_n = 1e6;
  settings.chain.damping_n_s_per_m = 4;
  rig.servo.exchange().settings.write(settings);
  rig.device.push = {1, 0, 0};
  double low = 1, high = -1;
  for (int n = 0; n < 4000; ++n) {
    rig.tick();
    if (n < 3000)
      continue;
    low = std::min(low, rig.x());
    high = std::max(high, rig.x());
  }
  CHECK(high - low < 1e-6);
  CHECK(high == approx(1.0 / 5000).epsilon(1e-3));
}

TEST_CASE("guidance by a patch reaches the hand, with an allowance and without") {
  // 1 N on a hand of 200 N/m: 5 mm at rest. A damper without a bound held the handle at 0.08 um.
  const auto guided = [](double allowance_w) {
    SimulatedDevice device;
    Servo servo;
    ServoSettings settings;
    settings.chain.allowance_w = allowance_w;
    servo.exchange().settings.write(settings);
    servo.attach(device);
    for (std::uint64_t k = 0; k < 3000; ++k) {
      const double now = static_cast<double>(k) * 1e-3;
      Command c;
      c.force_n = {k < 100 ? 0.0 : 1.0, 0, 0};
      c.number = k + 1;
      c.heartbeat_s = now;
      servo.exchange().commands.write(c);
      servo.step({k, now, 1e-3});
    }
    return device.position().x;
  };
  CHECK(guided(0) == approx(5e-3).epsilon(1e-3));
  CHECK(guided(0.05) == approx(5e-3).epsilon(1e-3));
}

TEST_CASE("a stiff wall that a patch renders a tick late is bounded with the default allowance") {
  const auto peak_to_peak = [](bool observer, double allowance_w) {
    Rig rig(0, observer);
    ServoSettings settings;
    settings.chain.passivity = observer;
    settings.chain.allowance_w = allowance_w;
    rig.servo.exchange().settings.write(settings);
    rig.device.push = {1, 0, 0};
    rig.device.device.set_state({-0.002, 0, 0}, {});
    double low = 1, high = -1;
    for (int n = 0; n < 4000; ++n) {
      Command c;
      c.force_n = {rig.x() > 0 ? -2000 * rig.x() : 0.0, 0, 0};
      c.number = rig.index + 1;
      c.heartbeat_s = static_cast<double>(rig.index) * 1e-3;
      rig.servo.exchange().commands.write(c);
      rig.tick();
      if (n < 3000)
        continue;
      low = std::min(low, rig.x());
      high = std::max(high, rig.x());
    }
    return high - low;
  };
  const double off = peak_to_peak(false, 0), strict = peak_to_peak(true, 0),
               allowed = peak_to_peak(true, 0.05);
  MESSAGE("patch wall of 2000 N/m, push 1 N: p-p " << off * 1e3 << " mm without observer, "
                                                   << strict * 1e3 << " with, " << allowed * 1e3
                                                   << " with and 50 mW");
  CHECK(strict < off);
  CHECK(allowed < off);
}

namespace {

using Scene = WallCase::Scene;
using Velocity = WallCase::Velocity;

/// Force rms with the controller over that without, where this is quiet. The bound on a flight's
/// energy is 1.005; 4 kN/m at 500 Hz, where the contact lasts eight ticks and the slew limit takes
/// two of them to let go, keeps 1.05.
void check_not_worse(const WallCase& c) {
  const WallResult off = run_wall(c, false), on = run_wall(c, true);
  CAPTURE(c.stiffness_n_per_m);
  CAPTURE(c.rate_hz);
  CAPTURE(c.encoder_m);
  CAPTURE(c.latency_ticks);
  CAPTURE(static_cast<int>(c.velocity));
  CAPTURE(static_cast<int>(c.scene));
  CAPTURE(c.value);
  CAPTURE(off.force_rms_n);
  CAPTURE(off.exit_energy);
  CHECK(on.max_slew <= 1 + 1e-9);
  CHECK(on.max_force_n <= c.force_limit_n * (1 + 1e-12));
  if (c.scene == Scene::kFlight) {
    REQUIRE(off.left);
    CHECK(on.left);
    CHECK(on.exit_energy <= (c.stiffness_n_per_m / c.rate_hz > 4 ? 1.05 : 1.005));
  } else if (off.stable()) {
    CHECK(on.force_rms_n <= std::max(1.1 * off.force_rms_n, 2e-3));
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
  WallCase loose_grip;
  loose_grip.stiffness_n_per_m = 500;
  loose_grip.encoder_m = 3.4e-5;
  loose_grip.velocity = Velocity::kEstimated;
  loose_grip.scene = Scene::kSpring;
  loose_grip.hand_n_per_m = 50;
  loose_grip.hand_n_s_per_m = 0.5;
  loose_grip.value = 5e-3;
  WallCase pushed;
  pushed.stiffness_n_per_m = 200;
  for (const WallCase& c : {person, loose_grip, pushed}) {
    check_not_worse(c);
    const WallResult off = run_wall(c, false, 4), on = run_wall(c, true, 4);
    MESSAGE(c.stiffness_n_per_m << " N/m: force rms " << off.force_rms_n << " without, "
                                << on.force_rms_n << " N with; motion " << off.motion_m * 1e3
                                << ", " << on.motion_m * 1e3 << " mm");
    CHECK(on.motion_m <= std::max(1.1 * off.motion_m, 2e-5));
  }
}

TEST_CASE("over walls, rates, encoders, velocities and hands the controller makes nothing worse") {
  // bench/haptic_passivity is the whole sweep.
  for (const double k : {50.0, 300.0, 1000.0, 4000.0})
    for (const double rate : {500.0, 1000.0})
      for (const double encoder : {0.0, 3.4e-5})
        for (const Velocity velocity : {Velocity::kIdeal, Velocity::kEstimated, Velocity::kNoisy}) {
          if (kSanitized && velocity != Velocity::kEstimated)
            continue;
          WallCase c;
          c.stiffness_n_per_m = k;
          c.rate_hz = rate;
          c.encoder_m = encoder;
          c.velocity = velocity;
          for (const double speed : {0.05, 0.2, 0.5}) {
            if (speed < 0.1 && encoder > 0)
              continue; // a contact of a few steps of the encoder
            c.scene = Scene::kFlight;
            c.value = speed;
            check_not_worse(c);
          }
          c.scene = Scene::kPush;
          c.value = 1;
          check_not_worse(c);
          c.scene = Scene::kSpring;
          c.value = 5e-3;
          check_not_worse(c);
          c.scene = Scene::kPerson;
          c.value = 2e-3;
          check_not_worse(c);
        }
}

TEST_CASE("latency makes a wall no noisier with the controller, whether it is declared or not") {
  for (const bool declared : {false, true})
    for (const int latency : {1, 2, 3})
      for (const double k : {50.0, 300.0, 1000.0})
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
      const double off = run_wall(c, false).exit_energy, assumed = run_wall(c, true).exit_energy;
      c.declared = true;
      const double declared = run_wall(c, true).exit_energy;
      MESSAGE(k << " N/m, " << latency << " ticks of latency: leaves with " << off
                << " of its energy without, " << assumed << " not declared, " << declared
                << " declared");
      CHECK(declared <= 1.005);
      if (latency <= 1)
        CHECK(assumed <= 1.005);
      if (latency == 3)
        CHECK(off > 1.1);
    }
}

TEST_CASE("a soft wall gives a flying handle its energy back") {
  // A limit on what a contact may release must not take the bounce from a wall that friction holds:
  // restitution by the damped half swing, exp(-2 pi z/sqrt(1 - z^2)) of the energy, with the
  // handle's 0.5 N s/m.
  WallCase c;
  c.stiffness_n_per_m = 200;
  c.declared = true;
  c.scene = Scene::kFlight;
  c.value = 0.2;
  const double z = 0.5 / (2 * std::sqrt(200 * 0.1));
  const double theory = std::exp(-2 * std::numbers::pi * z / std::sqrt(1 - z * z));
  const WallResult on = run_wall(c, true);
  MESSAGE("200 N/m at 0.2 m/s: leaves with " << on.exit_energy << " of its energy, theory "
                                             << theory);
  CHECK(on.exit_energy == approx(theory).epsilon(0.1));
}

TEST_CASE("negative energy is cleared once the handle is at rest, and not before") {
  PassivityController controller;
  PassivitySettings settings;
  controller.observe(settings, {}, {1, 0, 0}, 0);
  controller.observe(settings, {1e-3, 0, 0}, {1, 0, 0}, 0); // 1 N along 1 mm: 1 mJ given away
  CHECK(controller.energy_j() == approx(-1e-3).epsilon(1e-9));
  for (int tick = 0; tick < 49; ++tick)
    controller.observe(settings, {1e-3, 0, 0}, {}, 0);
  CHECK(controller.energy_j() == approx(-1e-3).epsilon(1e-9));
  controller.observe(settings, {1e-3, 0, 0}, {}, 0);
  controller.observe(settings, {1e-3, 0, 0}, {}, 0);
  CHECK(controller.energy_j() == 0);
  // A handle that moves on keeps it.
  PassivityController moving;
  for (int tick = 0; tick < 200; ++tick)
    moving.observe(settings, {tick * 1e-4, 0, 0}, {tick == 0 ? 0.0 : 1.0, 0, 0}, 0);
  CHECK(moving.energy_j() == approx(-199e-4).epsilon(0.01));
}

namespace {

/// Drives a controller along a line: the handle moves at that velocity, a tick after the other, at
/// a contact whose force is -K x along x, with a debt or a credit given at first.
struct ControllerRig {
  PassivityController controller;
  PassivitySettings settings;
  Vec3 position{};

  void give(double energy_j) { // to the observer, by a force of that energy over 1 m
    controller.observe(settings, position, {}, energy_j);
  }
  Vec3 step(const Vec3& velocity, const Vec3& reading, const Vec3& desired, const Vec3& contact) {
    position += velocity * settings.period_s;
    controller.observe(settings, position, {}, 0);
    return controller.limit(settings, desired, contact, reading);
  }
};

} // namespace

TEST_CASE(
    "the damper is no stronger than the device's limit and than the wall's created power needs") {
  for (const double period_s : {1e-3, 2e-3})
    for (const double stiffness : {100.0, 1e5}) { // c K T = 0.3 or 0.6, and beyond the limit
      ControllerRig rig;
      rig.settings.period_s = period_s;
      rig.settings.damping_limit_n_s_per_m = 4;
      rig.give(-1); // a large debt
      Vec3 force, desired;
      for (int tick = 0; tick < 100; ++tick) {
        desired = {-stiffness * (rig.position.x + 0.1 * period_s), 0, 0};
        force = rig.step({0.1, 0, 0}, {0.1, 0, 0}, desired, {}) - desired;
      }
      // At half the rate the device renders half the damping.
      const double limit = 4 * std::min(1.0, 1e-3 / period_s);
      CHECK(-force.x / 0.1 == approx(std::min(limit, 3 * stiffness * period_s)).epsilon(0.01));
    }
}

TEST_CASE("the damper removes no more than the negative energy, less that of an encoder step") {
  for (const double noise_m : {0.0, 5e-5}) {
    ControllerRig rig;
    rig.settings.damping_limit_n_s_per_m = 20;
    rig.settings.position_noise_m = noise_m;
    rig.give(-1e-5);
    Vec3 force, desired;
    for (int tick = 0; tick < 100; ++tick) {
      desired = {-1e4 * rig.position.x - 1e4 * 0.2e-3, 0, 0};
      force = rig.step({0.2, 0, 0}, {0.2, 0, 0}, desired, {}) - desired;
    }
    // u is the displacement over 2 ms less the reading's error. A step q = 0.1 mm at K = 1e4 N/m is
    // worth K q^2/2 = 5e-5 J, more than the debt.
    if (noise_m > 0)
      CHECK(force.x == 0);
    else
      CHECK(-force.x == approx(1e-5 / (1e-3 * 0.2)).epsilon(0.01));
  }
}

TEST_CASE(
    "the damper acts on the velocity that reading and displacement agree on, along the force") {
  const auto brake = [](const Vec3& velocity, const Vec3& reading) {
    ControllerRig rig;
    rig.settings.damping_limit_n_s_per_m = 2;
    rig.give(-1);
    Vec3 force, desired;
    for (int tick = 0; tick < 50; ++tick) {
      desired = {-1e5 * (rig.position.x + velocity.x * 1e-3), 0, 0};
      force = rig.step(velocity, reading, desired, {}) - desired;
    }
    return force;
  };
  CHECK(brake({0.1, 0, 0}, {0.1, 0, 0}).x == approx(-0.2).epsilon(1e-6));
  CHECK(brake({0.1, 0, 0}, {0.05, 0, 0}).x == approx(-0.1).epsilon(1e-6)); // the smaller
  CHECK(brake({0.1, 0, 0}, {-0.1, 0, 0}).x == 0);                          // noise, one of them
  const Vec3 oblique = brake({0.1, 0.3, -0.2}, {0.1, 0.3, -0.2});
  CHECK(oblique.x == approx(-0.2).epsilon(1e-6));
  CHECK(oblique.y == 0); // across the force nothing leaks
  CHECK(oblique.z == 0);
}

TEST_CASE("a contact that throws the handle back may release the remaining energy and no more") {
  // Approach at 0.4 m/s, back at some speed against 5 N, with some energy left; nothing else moves.
  const auto left_over = [](double back, double energy_j, double slew, int held_ticks = 0) {
    ControllerRig rig;
    rig.settings.tank_j = 1;
    rig.settings.damping_limit_n_s_per_m = 1e-9;
    rig.settings.slew_n_per_s = slew;
    Vec3 force;
    const auto go = [&](double v, int ticks) {
      for (int tick = 0; tick < ticks; ++tick) {
        const Vec3 contact{-1000 * (rig.position.x + v * 1e-3) - 5, 0, 0};
        force = rig.step({v, 0, 0}, {v, 0, 0}, contact, contact);
      }
    };
    go(0, held_ticks);
    go(0.4, 10);
    go(-back, 10);
    rig.give(energy_j);
    const Vec3 contact{-5, 0, 0};
    return -rig.step({-back, 0, 0}, {-back, 0, 0}, contact, contact).x;
  };
  // Thrown at 0.2 m/s: F T + F^2/(2 slew) = E/v.
  const double slew = 2000, T = 1e-3, v = 0.2, energy_j = 1e-3;
  const double affordable = slew * (std::sqrt(T * T + 2 * energy_j / (slew * v)) - T);
  REQUIRE(affordable < 5);
  CHECK(left_over(v, energy_j, slew) == approx(affordable).epsilon(1e-6));
  CHECK(left_over(v, energy_j, 1e9) == approx(5)); // at once: 5 mJ could be paid in one tick
  CHECK(left_over(v, 0, slew) == 0);
  CHECK(left_over(v, 0.1, slew) == approx(5));
  CHECK(left_over(0, 0, slew) == approx(5));      // at rest nothing is released
  CHECK(left_over(v, 0, slew, 100) == approx(5)); // a hand holds it in contact, and swings
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
  settings.device.damping_limit_n_s_per_m = 5;
  motors(state, false);
  for (int n = 0; n < 10; ++n) {
    state.passivity.observe({}, {x, 0, 0}, {}, -1);
    CHECK(tick(-0.3, {-20 - 1e3 * x, 0, 0}) == 0);
  }
}

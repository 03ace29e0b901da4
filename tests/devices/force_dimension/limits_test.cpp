#include "devices/force_dimension/limits.hpp"
#include "devices/force_dimension/stall_guard.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <thread>

using namespace tactus;
using namespace tactus::devices::force_dimension;

TEST_CASE("each model has the limits that CHAI3D 3.2 gives its type") {
  struct Family {
    std::initializer_list<int> types; // of dhdGetSystemType
    double force, stiffness, damping, radius, torque, grip;
  };
  const Family families[] = {
      {{33, 34, 36}, 12, 5000, 30, 0.075, 0, 0},          // omega.3, omega.6
      {{35, 37}, 12, 5000, 30, 0.075, 0, 8},              // omega.7: its gripper has a motor
      {{63}, 20, 5000, 30, 0.15, 0, 0},                   // delta.3
      {{64}, 20, 5000, 30, 0.15, 0.2, 0},                 // delta.6: so has its wrist
      {{206, 203}, 12, 4000, 30, 0.075, 0, 0},            // sigma.3, lambda.3
      {{106, 107}, 12, 4000, 30, 0.09, 0.2, 0},           // sigma.6+
      {{104, 105, 108, 109}, 12, 4000, 30, 0.075, 0.2, 8} // sigma.7, lambda.7
  };
  for (const Family& family : families)
    for (const int type : family.types) {
      CAPTURE(type);
      CHECK(model_of(type).type == type);
      const haptic::Caps caps = caps_of(model_of(type));
      CHECK(caps.peak_force_n == family.force);
      CHECK(caps.stiffness_limit_n_per_m == family.stiffness);
      CHECK(caps.damping_limit_n_s_per_m == family.damping);
      CHECK(caps.workspace_max == Vec3{1, 1, 1} * family.radius);
      CHECK(caps.workspace_min == Vec3{-1, -1, -1} * family.radius);
      CHECK(caps.peak_torque_n_m == family.torque);
      CHECK(caps.peak_grip_n == family.grip);
    }
}

TEST_CASE(
    "a lambda, of which no figure is public, has none above any other model's with such motors") {
  for (const int type : {203, 108, 109}) {
    const haptic::Caps lambda = caps_of(model_of(type));
    for (const int other : {33, 34, 35, 36, 37, 63, 64, 104, 105, 106, 107, 206}) {
      CAPTURE(other);
      const haptic::Caps caps = caps_of(model_of(other));
      CHECK(lambda.peak_force_n <= caps.peak_force_n);
      CHECK(lambda.stiffness_limit_n_per_m <= caps.stiffness_limit_n_per_m);
      CHECK(lambda.damping_limit_n_s_per_m <= caps.damping_limit_n_s_per_m);
      CHECK(lambda.workspace_max.x <= caps.workspace_max.x);
      if (caps.peak_torque_n_m > 0)
        CHECK(lambda.peak_torque_n_m <= caps.peak_torque_n_m);
      if (caps.peak_grip_n > 0)
        CHECK(lambda.peak_grip_n <= caps.peak_grip_n);
    }
  }
}

TEST_CASE("a type that nobody knows gets the least of all limits, which are the Falcon's") {
  const haptic::Caps falcon = caps_of(model_of(60)), unknown = caps_of(model_of(12345));
  for (const haptic::Caps& caps : {falcon, unknown}) {
    CHECK(caps.peak_force_n == 8);
    CHECK(caps.stiffness_limit_n_per_m == 3000);
    CHECK(caps.damping_limit_n_s_per_m == 20);
    CHECK(caps.workspace_max.x == 0.04);
    CHECK(caps.workspace_min.z == -0.04);
    CHECK(caps.peak_torque_n_m == 0);
    CHECK(caps.peak_grip_n == 0);
  }
  CHECK(model_of(60).name == "Falcon");
  CHECK(model_of(12345).name == "unknown");
  CHECK(model_of(132, "lambda.7 left").name == "lambda.7"); // as the library calls it
  CHECK(model_of(120, "theta.9").name == "unknown");
  CHECK(model_of(33, "lambda.7").name == "omega.3");
  CHECK(falcon.position_noise_m == 1e-5);
  CHECK(falcon.has_velocity);
  CHECK(falcon.needs_home);
}

TEST_CASE("a guard ends the force 50 ms after the last call, again and again, and never within "
          "one") {
  struct Seen {
    std::atomic<int> ends{0};
  } seen;
  StallGuard guard;
  const auto begun = std::chrono::steady_clock::now();
  REQUIRE(guard.start([](void* context) noexcept { ++static_cast<Seen*>(context)->ends; }, &seen) ==
          "");
  const auto wait_ms = [](int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); };
  const auto until = [&](int ends) {
    for (int i = 0; i < 5000 && seen.ends < ends; ++i)
      wait_ms(1);
    return seen.ends >= ends;
  };
  // From the start on it waits for the first call as for any other.
  CHECK(until(1));
  CHECK(std::chrono::steady_clock::now() - begun >= std::chrono::milliseconds(49));
  CHECK(until(4));
  // Inside a call nothing ends the force, however long it takes.
  bool entered = false;
  for (int i = 0; i < 5000 && !entered; ++i)
    entered = guard.enter();
  REQUIRE(entered);
  CHECK_FALSE(guard.enter());
  const int before = seen.ends;
  wait_ms(150);
  CHECK(seen.ends == before);
  // The time counts from the end of the call.
  const auto left = std::chrono::steady_clock::now();
  guard.leave();
  CHECK(until(before + 1));
  CHECK(std::chrono::steady_clock::now() - left >= std::chrono::milliseconds(49));
  guard.stop();
  const int stopped = seen.ends;
  wait_ms(100);
  CHECK(seen.ends == stopped);
}

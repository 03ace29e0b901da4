#include "tests/devices/force_dimension/fake.hpp"

#include <doctest/doctest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>
#include <thread>

using namespace tactus;

namespace {

/// Writes this force until the device has it in full: one that begins to write rises over 0.1 s.
bool press(const Fake& fake, haptic::Backend& device, const Vec3& force, const Vec3& expected) {
  for (int i = 0; i < 5000; ++i) {
    static_cast<void>(device.write(force));
    if (norm(fake.force() - expected) < 1e-12)
      return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

} // namespace

TEST_CASE("the vendor's frame becomes the project's, for positions and for forces, which move it") {
  const auto [fake, device] = Opened();
  fake.set_position(0.01, 0.02, 0.03); // towards the user, right, up
  CHECK(drive(*device, {}, 1).position == Vec3{0.02, 0.03, 0.01});
  CHECK(press(fake, *device, {1, 2, 3}, {3, 1, 2}));
  fake.set_position(0, 0, 0);
  REQUIRE(press(fake, *device, {0, 0.5, 0}, {0, 0, 0.5}));
  const State state = drive(*device, {0, 0.5, 0}, 100);
  CHECK(state.position.y > 1e-3);
  CHECK(state.velocity.y > 0);
  CHECK(std::abs(state.position.x) < 1e-3);
}

TEST_CASE("an omega has its limits, its own watchdog and its own clamp") {
  const auto [fake, device] = Opened();
  CHECK(device->identity().model == "omega.3");
  CHECK(device->identity().serial == "1234");
  CHECK(device->caps().peak_force_n == 12);
  CHECK(device->caps().workspace_max.x == doctest::Approx(0.075));
  CHECK(fake.counts()[2] == 0); // before the first force nobody feeds it
  REQUIRE(device->write({}));
  CHECK(fake.counts()[2] == 240);
  CHECK(fake.counts()[3] == 0); // expert mode for the watchdog only
  CHECK(fake.max_force() == 12);
  // no more than the peak, in the same direction
  CHECK(press(fake, *device, {30, 40, 0}, {0, 7.2, 9.6}));
  std::this_thread::sleep_for(std::chrono::milliseconds(150)); // thrice what a guard would wait
  CHECK(norm(fake.force()) == doctest::Approx(12));
  CHECK_FALSE(device->write({NAN, 0, 0}));
  CHECK(fake.force() == Vec3{});
}

TEST_CASE("closing leaves no force and the motors off, and the device opens again") {
  const Fake fake;
  const auto device = make();
  for (int round = 0; round < 3; ++round) {
    REQUIRE(device->open() == "");
    drive(*device, {1, 1, 1}, 3);
    device->close();
    CHECK(fake.force() == Vec3{});
    CHECK(fake.counts()[0] == 0);
    CHECK(fake.counts()[1] == 0);
  }
  State state;
  CHECK_FALSE(device->read({}, state));
  CHECK_FALSE(device->write({}));
}

TEST_CASE("a device that stops answering is told, and is well again when it answers") {
  const auto [fake, device] = Opened();
  fake.set(1, 0, 0, 0);
  State state;
  CHECK_FALSE(device->read({}, state));
  CHECK_FALSE(device->write({1, 0, 0}));
  CHECK(device->trouble().find("communication error") != std::string::npos);
  fake.set(0, 0, 0, 5);
  CHECK(device->read({}, state));
  CHECK(state.buttons == 5);
  CHECK(device->trouble() == "");
}

TEST_CASE("the force button is the owner's: only pressing it again brings force back") {
  const auto [fake, device] = Opened();
  fake.switch_off(1);
  CHECK((drive(*device, {}, 1000).flags & State::kFault) != 0);
  CHECK(fake.counts()[1] == 0);
  CHECK(device->trouble().find("force button") != std::string::npos);
  fake.switch_on();
  CHECK((drive(*device, {}, 100).flags & State::kFault) == 0);
}

TEST_CASE("an uncalibrated device refuses a force until it has been calibrated; a saturated motor "
          "is told") {
  const auto [fake, device] = Opened();
  CHECK((drive(*device, {1, 0, 0}, 100).flags & State::kHomed) != 0);
  const std::array<std::string, 1> home{"home"};
  CHECK(device->configure(home) == "");
  CHECK((drive(*device, {1, 0, 0}, 100).flags & State::kHomed) == 0);
  CHECK(fake.force() == Vec3{});
  CHECK_FALSE(device->write({1, 0, 0}));
  CHECK(device->write({}));
  CHECK(device->trouble().find("calibration pole") != std::string::npos);
  fake.set(0, 1, 0, 0); // the pole was in its pit; a motor saturates
  const State state = drive(*device, {1, 0, 0}, 100);
  CHECK((state.flags & State::kHomed) != 0);
  CHECK((state.flags & State::kForceLimited) != 0);
}

TEST_CASE("a library that is missing, incomplete, loaded twice or without a device is told") {
  is_told_of_its_library<Fake>("forcedimension.com", FAKE_DHD_INCOMPLETE, "dhdSetForce");
  is_loaded_and_opened_once<Fake>("1234", "FAKE_DHD_LOADS");
  opens_in_vain<Fake>("none", "device 0 cannot be opened (no device found; 0 connected)");
  CHECK(devices::find_driver("dhd")->list().empty());
}

TEST_CASE("without a watchdog in the controller a servo that stalls leaves no force") {
  const auto [fake, device] = Opened("no watchdog");
  for (int round = 0; round < 2; ++round) {
    const auto begun = std::chrono::steady_clock::now();
    REQUIRE(press(fake, *device, {1, 2, 3}, {3, 1, 2}));
    CHECK(std::chrono::steady_clock::now() - begun > std::chrono::milliseconds(95)); // softly
    bool none = false; // nobody reads or writes
    for (int i = 0; i < 5000 && !none; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      none = fake.force() == Vec3{};
    }
    CHECK(none);
  }
  CHECK(press(fake, *device, {1, 2, 3}, {3, 1, 2}));
  device->close();
  CHECK(fake.force() == Vec3{});
}

TEST_CASE(
    "a sigma.7 is sent torque and gripper force only once it was asked, and none at the end") {
  const auto [fake, device] = Opened("sigma.7");
  CHECK(device->caps().peak_torque_n_m == 0.2);
  CHECK(device->caps().peak_grip_n == 8);
  CHECK(device->caps().has_gripper);
  fake.gap(0.012);
  CHECK(drive(*device, {}, 1).gripper_m == 0.012);
  REQUIRE(press(fake, *device, {1, 2, 3}, {3, 1, 2}));
  CHECK(fake.wrist().second == 0); // only dhdSetForce so far
  device->set_wrist({{0.01, 0.02, 0.03}, -5});
  CHECK(device->write({1, 2, 3}));
  CHECK(norm(fake.force() - Vec3{3, 1, 2}) < 1e-12);
  CHECK(fake.wrist().first == std::array<double, 4>{0.03, 0.01, 0.02, -5});
  CHECK(device->write({1, 2, 3})); // nobody asked for this one
  CHECK(fake.wrist().first == std::array<double, 4>{});
  CHECK(norm(fake.force() - Vec3{3, 1, 2}) < 1e-12);
  device->set_wrist({{3, 4, 0}, 100}); // no more than the peaks
  CHECK(device->write({}));
  const auto limited = fake.wrist().first;
  CHECK(limited[0] == doctest::Approx(0));
  CHECK(limited[1] == doctest::Approx(0.12));
  CHECK(limited[2] == doctest::Approx(0.16));
  CHECK(limited[3] == 8);
  device->set_wrist({{NAN, 0, 0}, NAN});
  CHECK(device->write({}));
  CHECK(fake.wrist().first == std::array<double, 4>{});
  fake.set(0, 0, 1, 0); // not calibrated
  drive(*device, {}, 100);
  device->set_wrist({{0, 0.1, 0}, 1});
  static_cast<void>(device->write({}));
  CHECK(fake.wrist().first == std::array<double, 4>{});
  fake.set(0, 0, 0, 0);
  drive(*device, {}, 100);
  device->set_wrist({{0, 0.1, 0}, 1});
  CHECK(device->write({}));
  CHECK(fake.wrist().first[2] != 0);
  device->close();
  CHECK(fake.wrist().first == std::array<double, 4>{});
}

TEST_CASE("an omega.7 grips and has no torque; an omega.3 has neither and is sent neither") {
  {
    const auto [fake, device] = Opened("omega.7");
    CHECK(device->caps().peak_torque_n_m == 0);
    CHECK(device->caps().peak_grip_n == 8);
    REQUIRE(press(fake, *device, {0, 0, 1}, {1, 0, 0}));
    device->set_wrist({{0.1, 0.1, 0.1}, 2});
    CHECK(device->write({}));
    CHECK(fake.wrist().first == std::array<double, 4>{0, 0, 0, 2});
  }
  const auto [fake, device] = Opened();
  CHECK(device->caps().peak_grip_n == 0);
  CHECK_FALSE(device->caps().has_gripper);
  device->set_wrist({{0.1, 0.1, 0.1}, 2});
  CHECK(device->write({}));
  CHECK(fake.wrist().second == 0);
}

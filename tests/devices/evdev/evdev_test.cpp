#include "devices/driver.hpp"
#include "tests/devices/mock/control.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <string>
#include <thread>

#include <linux/input.h>

using namespace tactus;
using haptic::State;
using haptic::Vec3;

namespace {

const mock::Control stick;

std::unique_ptr<haptic::Backend> make() { return devices::find_driver("evdev")->make(); }

/// Ticks like a servo's until the condition holds, half a minute at most.
template <class Condition>
bool drive_until(haptic::Backend& device, const Vec3& force, Condition holds) {
  for (int i = 0; i < 30000; ++i) {
    State state;
    const bool answered = device.read({}, state);
    static_cast<void>(device.write(force));
    if (holds(answered, state))
      return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

std::string axis(int code, int value) {
  return "axis " + std::to_string(code) + " " + std::to_string(value);
}

} // namespace

TEST_CASE("the stick that can hold a force is listed, the keyboard is not") {
  REQUIRE(stick.present());
  const auto found = devices::find_driver("evdev")->list();
  REQUIRE(found.size() == 1);
  CHECK(found[0].identity.model == "Double Stick");
  CHECK(found[0].identity.serial == "STICK7");
  CHECK(found[0].state == "ready");
}

TEST_CASE("deflection is position: right, towards the user, and the third axis up") {
  const auto device = make();
  REQUIRE(device->open() == "");
  CHECK(device->caps().axes_in == 3);
  CHECK(device->caps().axes_out == 2);
  stick.ask(axis(ABS_X, 32767));
  stick.ask(axis(ABS_Y, -32768));
  CHECK(drive_until(*device, {}, [](bool answered, const State& state) {
    // 0 lies half a count above the middle of the third axis.
    return answered && norm(state.position - Vec3{0.05, 0, -0.05}) < 1e-6;
  }));
  stick.ask(axis(ABS_Z, 32767));
  stick.ask("key " + std::to_string(BTN_TRIGGER) + " 1");
  CHECK(drive_until(*device, {}, [](bool, const State& state) {
    return state.position.y == 0.05 && state.buttons == 1;
  }));
  stick.ask("key " + std::to_string(BTN_TRIGGER) + " 0");
  CHECK(drive_until(*device, {}, [](bool, const State& state) { return state.buttons == 0; }));
}

TEST_CASE("after lost events the axes are asked for") {
  const auto device = make();
  REQUIRE(device->open() == "");
  stick.ask("drop 16384");
  CHECK(drive_until(*device, {}, [](bool, const State& state) {
    return state.position.x > 0.0249 && state.position.x < 0.0251;
  }));
}

TEST_CASE("a force is one effect that is played once and changed, and ends with the servo") {
  const auto device = make();
  const std::array<std::string, 2> peak{"peak", "2"};
  REQUIRE(device->configure(peak) == "");
  REQUIRE(device->open() == "");
  CHECK(stick.value("effects") == 1);
  CHECK(stick.value("playing") == 1);
  CHECK(stick.value("gain") == 0xFFFF);
  CHECK(drive_until(*device, {1, 0, 0}, [](bool, const State&) {
    return stick.value("level") == 16384 && stick.value("direction") == 0xC000;
  }));
  CHECK(drive_until(*device, {0, 0, 2}, [](bool, const State&) {
    return stick.value("level") == 32767 && stick.value("direction") == 0;
  }));
  const long uploads = stick.value("uploads");
  for (int i = 0; i < 30; ++i)
    drive_until(*device, {0, 0, 2}, [](bool answered, const State&) { return answered; });
  CHECK(stick.value("uploads") == uploads); // nothing new, nothing sent
  bool fell = false;
  for (int i = 0; i < 5000 && !fell; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    fell = stick.value("level") == 0;
  }
  CHECK(fell);
  CHECK(drive_until(*device, {1, 0, 0},
                    [](bool, const State&) { return stick.value("level") != 0; }));
  device->close();
  CHECK(stick.value("level") == 0);
  CHECK(stick.value("effects") == 0);
  State state;
  CHECK_FALSE(device->read({}, state));
  CHECK(device->open() == "");
}

TEST_CASE("a device that takes no force any more says so, and is well when it does") {
  const auto device = make();
  REQUIRE(device->open() == "");
  stick.ask("fail " + std::to_string(ENODEV));
  CHECK(drive_until(*device, {1, 0, 0}, [&](bool, const State&) {
    return device->trouble().find("gone") != std::string::npos;
  }));
  CHECK_FALSE(device->write({}));
  stick.ask("fail 0");
  CHECK(
      drive_until(*device, {1, 0, 0}, [&](bool, const State&) { return device->trouble() == ""; }));
  stick.ask("fail " + std::to_string(ENOSPC));
  const auto other = make();
  CHECK(other->open().find("takes no force") != std::string::npos);
  stick.ask("fail 0");
}

TEST_CASE("a device is chosen by index, node or serial number") {
  const auto device = make();
  for (const char* which : {"0", "/dev/input/event3", "STICK7"}) {
    const std::array<std::string, 2> wish{"device", which};
    CHECK(device->configure(wish) == "");
    CHECK(device->open() == "");
  }
  const std::array<std::string, 2> none{"device", "5"}, odd{"reach", "0"};
  CHECK(device->configure(none) == "");
  CHECK(device->open().find("Double Stick") != std::string::npos);
  CHECK(device->configure(odd).find("reach MM") != std::string::npos);
}

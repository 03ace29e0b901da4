#include "devices/driver.hpp"
#include "tests/devices/mock/control.hpp"

#include <doctest/doctest.h>

#include <cerrno>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include <linux/input.h>
#include <unistd.h>

using namespace tactus;
using haptic::State;

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

std::string set(haptic::Backend& device, const std::vector<std::string>& words) {
  return device.configure(words);
}

bool drive_until_level(haptic::Backend& device, const Vec3& force, long level) {
  return drive_until(device, force,
                     [level](bool, const State&) { return stick.value("level") == level; });
}

/// Until the stick has both: on a machine that stalls, the device ends its force meanwhile.
bool drive_until_effect(haptic::Backend& device, const Vec3& force, long level, long direction) {
  return drive_until(device, force, [=](bool, const State&) {
    return stick.value("level") == level && stick.value("direction") == direction;
  });
}

bool drive_until_buttons(haptic::Backend& device, unsigned buttons) {
  return drive_until(device, {},
                     [buttons](bool, const State& state) { return state.buttons == buttons; });
}

} // namespace

TEST_CASE("what can hold a force is listed in the order of its nodes, the keyboard is not") {
  REQUIRE(stick.present());
  const auto found = devices::find_driver("evdev")->list();
  REQUIRE(found.size() == 3);
  CHECK(found[0].index == 0);
  CHECK(found[1].index == 1);
  CHECK(found[1].identity.model == "Silent Wheel"); // event12, after event3
  CHECK(found[2].identity.model == "Silent Stick"); // event21
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
  CHECK(drive_until(*device, {}, [](bool, const State& s) { return s.position.y == 0.05; }));
  stick.ask("drop 16384"); // after lost events the axes are asked for
  CHECK(drive_until(*device, {}, [](bool, const State& state) {
    return state.position.x > 0.0249 && state.position.x < 0.0251;
  }));
}

TEST_CASE("a force is one effect that is changed and started again, and ends with the servo") {
  const auto device = make();
  REQUIRE(set(*device, {"peak", "2"}) == "");
  for (int opening = 0; opening < 2; ++opening) { // again, without closing
    REQUIRE(device->open() == "");
    CHECK(stick.value("effects") == 1);
  }
  CHECK(stick.value("level") == 0);
  CHECK(stick.value("playing") == 1);
  CHECK(stick.value("gain") == 0xFFFF);
  CHECK(stick.value("centre") == 0); // the device's own spring
  CHECK(stick.value("length") > 0);  // 0 and more than 32767 ms are not the same for all drivers
  CHECK(stick.value("length") <= 32767);
  CHECK(drive_until_effect(*device, {1, 0, 0}, 16384, 0xC000));
  CHECK(drive_until_effect(*device, {0, 0, 2}, 32767, 0));
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
  CHECK(drive_until_level(*device, {1, 0, 0}, 16384));
  device->close();
  CHECK(stick.value("level") == 0);
  CHECK(stick.value("effects") == 0);
  State state;
  CHECK_FALSE(device->read({}, state));
  CHECK(device->open() == "");
}

namespace {

/// A constant force is felt at each of these times with every temper of the kernel's drivers.
void feels_constant_force(const std::vector<double>& times_s) {
  const auto felt = [](long level) {
    return [level](bool, const State&) {
      return stick.value("felt0") == level && stick.value("felt1") == level &&
             stick.value("felt2") == level && stick.value("felt3") == level;
    };
  };
  const auto device = make();
  REQUIRE(device->open() == "");
  REQUIRE(drive_until(*device, {-1, 0, 0}, felt(10922)));
  const long lapses = stick.value("lapses"), starts = stick.value("starts");
  using Clock = std::chrono::steady_clock;
  const auto begun = Clock::now();
  for (const double time_s : times_s) {
    while (Clock::now() - begun < std::chrono::duration<double>(time_s))
      REQUIRE(drive_until(*device, {-1, 0, 0}, [](bool, const State&) { return true; }));
    CHECK(drive_until(*device, {-1, 0, 0}, felt(10922)));
  }
  CHECK(drive_until(*device, {-1, 0, 0},
                    [&](bool, const State&) { return stick.value("starts") >= starts + 3; }));
  CHECK(stick.value("lapses") == lapses); // felt without a gap
  CHECK(drive_until(*device, {}, felt(0)));
}

} // namespace

TEST_CASE("a constant force is felt with every kind of driver") { feels_constant_force({}); }

TEST_CASE("a constant force is felt for 70 s with every kind of driver" *
          doctest::test_suite("slow")) {
  feels_constant_force({1, 30, 64, 66, 70});
}

TEST_CASE("a device that takes no force any more says so, and is well when it does") {
  const auto device = make();
  REQUIRE(device->open() == "");
  stick.ask("fail " + std::to_string(ENODEV));
  CHECK(drive_until(*device, {1, 0, 0}, [&](bool, const State&) {
    return device->trouble().find("unplugged") != std::string::npos;
  }));
  CHECK_FALSE(device->write({}));
  stick.ask("fail 0");
  CHECK(
      drive_until(*device, {1, 0, 0}, [&](bool, const State&) { return device->trouble() == ""; }));
  stick.ask("fail " + std::to_string(ENOSPC));
  const auto other = make();
  CHECK(other->open().find("refuses a force") != std::string::npos);
  stick.ask("fail 0");
}

TEST_CASE("a device is chosen by index, node or serial number") {
  const auto device = make();
  for (const char* which : {"0", "/dev/input/event3", "STICK7"}) {
    CHECK(set(*device, {"device", which}) == "");
    CHECK(device->open() == "");
  }
  for (const char* which : {"3", "1x", "-1", "/dev/input/event4", "stick7"}) {
    CHECK(set(*device, {"device", which}) == "");
    CHECK(device->open().find(
              "among 3 devices; the first is device 0, /dev/input/event3, Double Stick") !=
          std::string::npos);
  }
  for (const char* which : {"1", "/dev/input/event12"}) { // it answers nothing
    CHECK(set(*device, {"device", which}) == "");
    CHECK(device->open().find("/dev/input/event12 has no axis X") != std::string::npos);
  }
}

TEST_CASE("a setting is a name and one value within its range") {
  const auto device = make();
  for (const char* value : {"1", "1000"})
    CHECK(set(*device, {"reach", value}) == "");
  for (const char* value : {"0.1", "40"})
    CHECK(set(*device, {"peak", value}) == "");
  for (const char* value : {"0.99", "1001", "nan", "50mm", ""})
    CHECK(set(*device, {"reach", value}).find("expected 1..1000 mm") != std::string::npos);
  for (const char* value : {"0.09", "40.1"})
    CHECK(set(*device, {"peak", value}).find("expected 0.1..40 N") != std::string::npos);
  for (const char* value : {"0", "1", "auto"})
    CHECK(set(*device, {"wheel", value}) == "");
  CHECK(set(*device, {"wheel", "2"}).find("expected 0, 1 or auto") != std::string::npos);
  CHECK(set(*device, {"reverse", "auto"}).find("expected 0 or 1") != std::string::npos);
  CHECK(set(*device, {}).find("evdev: setting nothing: expected") == 0);
  CHECK(set(*device, {"device", "0", "1"}) != "");
}

TEST_CASE("what a device can do is asked of its axes, and full deflection is the reach") {
  const auto device = make();
  REQUIRE(set(*device, {"reach", "20"}) == "");
  REQUIRE(set(*device, {"peak", "7"}) == "");
  stick.ask("range 100 900");
  for (const int axes : {3, 2, 1}) {
    stick.ask("axes " + std::to_string(axes));
    REQUIRE(device->open() == "");
    const haptic::Caps caps = device->caps();
    CHECK(caps.axes_in == axes);
    CHECK(caps.axes_out == (axes > 1 ? 2 : 1));
    CHECK(caps.peak_force_n == 7);
    CHECK(caps.workspace_min == Vec3{-0.02, -0.02, -0.02});
    CHECK(caps.workspace_max == Vec3{0.02, 0.02, 0.02});
    CHECK(caps.position_noise_m == doctest::Approx(0.02 / 800)); // half of one of 800 steps
    CHECK(caps.rate_hz == 250);
    CHECK(caps.has_buttons);
    stick.ask(axis(ABS_X, 700)); // half the way from the middle, 500
    stick.ask(axis(ABS_Y, 5000));
    stick.ask(axis(ABS_Z, 300));
    // An axis that is not there stays in the middle, whatever is said of it.
    const Vec3 expected{0.01, axes > 2 ? -0.01 : 0, axes > 1 ? 0.02 : 0};
    CHECK(drive_until(*device, {}, [&](bool, const State& state) {
      return norm(state.position - expected) < 1e-12;
    }));
    // Force to the side, and towards the user where there is an axis for it.
    CHECK(drive_until_level(*device, {0, 0, 7}, axes > 1 ? 32767 : 0));
    CHECK(drive_until_level(*device, {-3.5, 5, 0}, 16384));
    CHECK(stick.value("direction") == 0x4000);
    // A wheel's driver may ignore the direction: there the sign is the level's.
    CHECK(drive_until_level(*device, {1.75, 5, 0}, axes > 1 ? 8192 : -8192));
    CHECK(stick.value("direction") == (axes > 1 ? 0xC000 : 0x4000));
    device->close();
  }
  stick.ask("axes 2"); // the second may be a pedal
  REQUIRE(set(*device, {"wheel", "1"}) == "");
  REQUIRE(set(*device, {"reverse", "1"}) == "");
  REQUIRE(device->open() == "");
  CHECK(device->caps().axes_out == 1);
  CHECK(drive_until_level(*device, {3.5, 0, 7}, 16384));
  CHECK(stick.value("direction") == 0x4000);
  REQUIRE(set(*device, {"wheel", "auto"}) == "");
  REQUIRE(set(*device, {"reverse", "0"}) == "");
  stick.ask("axes 0");
  CHECK(device->open().find("no axis X") != std::string::npos);
  CHECK(make()->open().find("no axis X") != std::string::npos);
  CHECK(stick.value("effects") == 0); // a refused opening takes away no effect, having made none
  stick.ask("axes 3");
  stick.ask("range 900 900"); // no way to go
  CHECK(device->open().find("no axis X") != std::string::npos);
  stick.ask("range -32768 32767");
  stick.ask(axis(ABS_X, 16384));
  REQUIRE(device->open() == ""); // where it is at the opening is known without an event
  State state;
  CHECK(device->read({}, state));
  CHECK(state.position.x == doctest::Approx(0.02 * 16384.5 / 32767.5));
}

TEST_CASE("each button has its bit, in the order of their codes, also after lost events") {
  const auto device = make();
  stick.ask("key " + std::to_string(BTN_THUMB) + " 1");
  stick.ask("key " + std::to_string(KEY_MAX - 7) + " 1");
  REQUIRE(device->open() == "");
  State state;
  CHECK(device->read({}, state));
  CHECK(state.buttons == 20u); // down since before the opening
  stick.ask("key " + std::to_string(KEY_MAX - 7) + " 0");
  const auto press = [](int key, int down) {
    stick.ask("key " + std::to_string(key) + " " + std::to_string(down));
  };
  press(BTN_MISC, 1);
  press(BTN_GAMEPAD, 1);
  press(BTN_THUMB, 0);
  press(KEY_A, 1); // is none of them
  CHECK(drive_until_buttons(*device, 9));
  stick.ask("lift " + std::to_string(BTN_MISC)); // nobody hears of it
  CHECK(drive_until_buttons(*device, 9));
  stick.ask("drop 0");
  CHECK(drive_until_buttons(*device, 8));
  press(KEY_MAX - 7, 1); // the last of them
  CHECK(drive_until_buttons(*device, 24));
  press(KEY_MAX - 7, 0);
  press(BTN_GAMEPAD, 0);
  CHECK(drive_until_buttons(*device, 0));
}

TEST_CASE("a program without standard input may have the device as its file 0") {
  const int kept = dup(0);
  close(0);
  const auto device = make();
  const std::string sentence = device->open();
  State state;
  const bool read = device->read({}, state), written = device->write({});
  device->close();
  dup2(kept, 0);
  close(kept);
  CHECK(sentence == "");
  CHECK(read);
  CHECK(written);
}

TEST_CASE("many events are read within few ticks, and an axis moves with its event") {
  const auto device = make();
  REQUIRE(device->open() == "");
  for (int i = 0; i < 60; ++i) // as many as a pseudo-terminal holds
    stick.ask(axis(ABS_X, i));
  stick.ask("half 0 32767");
  int ticks = 0; // 121 events
  CHECK(drive_until(*device, {}, [&](bool, const State& state) {
    ++ticks;
    return state.position.x == 0.05;
  }));
  CHECK(ticks <= 20); // the kernel hands them on in its own time
}

TEST_CASE("a force that was refused is sent again until it is taken, 250 times a second at most") {
  const auto device = make();
  REQUIRE(device->open() == "");
  REQUIRE(drive_until_level(*device, {1, 0, 0}, 10922));
  stick.ask("fail " + std::to_string(EBUSY));
  const long before = stick.value("refusals");
  const auto begun = std::chrono::steady_clock::now();
  CHECK(drive_until(*device, {2, 0, 0},
                    [&](bool, const State&) { return stick.value("refusals") >= before + 50; }));
  CHECK(std::chrono::steady_clock::now() - begun >= std::chrono::milliseconds(190));
  CHECK(device->trouble().find("the device refuses a force") != std::string::npos);
  CHECK_FALSE(device->write({2, 0, 0}));
  stick.ask("fail 0");
  CHECK(drive_until_level(*device, {2, 0, 0}, 21845));
  CHECK(drive_until(*device, {2, 0, 0},
                    [&](bool, const State&) { return device->trouble().empty(); }));
}

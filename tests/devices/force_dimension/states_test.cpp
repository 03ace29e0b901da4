#include "tests/devices/force_dimension/fake.hpp"

#include <doctest/doctest.h>

#include <set>
#include <string>
#include <vector>

// What the device says of itself, and what the driver does about it.

using namespace tactus;

namespace {

std::string set(haptic::Backend& device, const std::vector<std::string>& words) {
  return device.configure(words);
}

} // namespace

TEST_CASE("angles, gripper and buttons are read in the project's axes, and no number is none") {
  const auto [fake, device] = Opened("sigma.7");
  CHECK(device->caps().has_rotation);
  CHECK(device->caps().has_buttons);
  CHECK(device->identity().vendor == "Force Dimension");
  fake.set(0, 0, 0, 9);
  fake.gap(0.02);
  State state = drive(*device, {}, 1);
  CHECK(state.rotation == Vec3{0.2, 0.3, 0.1}); // towards the user 0.1, right 0.2, up 0.3
  CHECK(state.gripper_m == 0.02);
  CHECK(state.buttons == 9);
  fake.gap(NAN);
  state.gripper_m = 0.5;
  CHECK(device->read({}, state));
  CHECK(state.gripper_m == 0.5);
  const Fake plain;
  const auto omega = make();
  device->close();
  REQUIRE(omega->open() == "");
  CHECK_FALSE(omega->caps().has_rotation);
  CHECK(drive(*omega, {}, 1).rotation == Vec3{});
}

TEST_CASE("each reason for motors that are off has a sentence; those of the hand wait for it") {
  std::set<std::string> sentences;
  for (int cause = 0; cause <= 6; ++cause) {
    CAPTURE(cause);
    const auto [fake, device] = Opened();
    const bool by_hand = cause == 1 || cause == 5 || cause == 6; // button, cable, grip
    fake.switch_off(cause);
    drive(*device, {1, 0, 0}, 70);
    const std::string sentence = device->trouble();
    CHECK(sentence.substr(0, 5) == "dhd: ");
    if (cause == 0) // it does not say why: as by software
      CHECK(sentence.find("the motors are off") != std::string::npos);
    else if (cause != 4)
      CHECK(sentences.insert(sentence).second);
    drive(*device, {}, 400);
    CHECK(fake.counts()[1] == !by_hand);
    CHECK(device->trouble() == (by_hand ? sentence : ""));
  }
  CHECK(sentences.size() == 5);
}

TEST_CASE("motors come on again a fifth of a second after the last force, at the next look") {
  const auto [fake, device] = Opened();
  for (const int before : {100, 117}) { // whenever the looks, every 64 ticks, fall
    fake.switch_off(3);
    drive(*device, {1, 0, 0}, before);
    REQUIRE(fake.counts()[1] == 0);
    int ticks = 0;
    while (fake.counts()[1] == 0 && ticks < 1000) {
      drive(*device, {}, 1);
      ++ticks;
    }
    CHECK(ticks >= 200);
    CHECK(ticks <= 200 + 65);
    drive(*device, {}, 64);
    CHECK(device->trouble() == "");
    drive(*device, {1, 0, 0}, 10);
  }
  // Force in between starts the fifth of a second anew.
  fake.switch_off(3);
  drive(*device, {1, 0, 0}, 70);
  for (int i = 0; i < 6; ++i) {
    drive(*device, {}, 190);
    drive(*device, {0, 0, 1e-3}, 1);
  }
  CHECK(fake.counts()[1] == 0);
}

TEST_CASE("the status is asked for once in 64 ticks, from the first on") {
  const auto [fake, device] = Opened();
  const int before = fake.calls()[1];
  drive(*device, {}, 1);
  CHECK(fake.calls()[1] == before + 1);
  drive(*device, {}, 640);
  CHECK(fake.calls()[1] == before + 11);
}

TEST_CASE("a fault of the device is a fault of the state, and its repair ends it") {
  const auto [fake, device] = Opened();
  State state = drive(*device, {}, 70);
  CHECK(state.flags == State::kHomed);
  fake.break_down(1);
  state = drive(*device, {}, 70);
  CHECK(state.flags == (State::kHomed | State::kFault));
  CHECK(device->trouble().find("fault") != std::string::npos);
  fake.break_down(0);
  state = drive(*device, {}, 70);
  CHECK(state.flags == State::kHomed);
  CHECK(device->trouble() == "");
}

TEST_CASE("an opening forgets what was wrong before it, and begins without force") {
  const auto [fake, device] = Opened("sigma.7");
  fake.set_position(0.01, 0.01, 0.01);
  drive(*device, {}, 2);
  fake.set(0, 1, 1, 0);
  fake.break_down(1);
  fake.switch_off(1);
  device->set_wrist({{0, 0, 0.1}, 1});
  drive(*device, {1, 1, 1}, 70);
  CHECK(device->trouble() != "");
  REQUIRE(device->open() == "");
  CHECK(device->trouble() == "");
  fake.set_position(5, 0, 0); // no position that it can have: the last good one is the middle
  State state;
  CHECK(device->read({}, state));
  CHECK(state.position == Vec3{});
  CHECK(state.flags == (State::kHomed | State::kUnreachable));
  CHECK(device->write({1, 1, 1})); // rises over 0.1 s
  CHECK(fake.force() == Vec3{});
  CHECK(fake.wrist().second == 0);
  CHECK(fake.counts()[1] == 1);
}

TEST_CASE("a position out of reach is the last good one") {
  const auto [fake, device] = Opened();
  fake.set_position(0.01, 0.02, 0.03);
  const Vec3 good = drive(*device, {}, 1).position;
  fake.set_position(0.01, 9, 0.03);
  const State state = drive(*device, {}, 1);
  CHECK(state.position == good);
  CHECK((state.flags & State::kUnreachable) != 0);
}

TEST_CASE("an opening tries three times, and a list leaves an open device alone") {
  const Fake none("none");
  const int before = none.calls()[0];
  CHECK(make()->open() != "");
  CHECK(none.calls()[0] == before + 3);
  const auto [fake, device] = Opened();
  const int counts = fake.device_counts();
  CHECK(devices::find_driver("dhd")->list().size() == 1);
  CHECK(fake.device_counts() == counts);
}

TEST_CASE(
    "a number below 64 is an index, from there on a serial number, and nothing else is either") {
  const Fake fake("many");
  const auto device = make();
  for (const char* index : {"0", "5", "63"}) {
    REQUIRE(set(*device, {"device", index}) == "");
    REQUIRE(device->open() == "");
    const auto listed = devices::find_driver("dhd")->list();
    REQUIRE(listed.size() == 1);
    CHECK(std::to_string(listed[0].index) == index);
  }
  REQUIRE(set(*device, {"device", "1234"}) == "");
  REQUIRE(device->open() == "");
  CHECK(devices::find_driver("dhd")->list().at(0).index == 0);
  REQUIRE(set(*device, {"device", "64"}) == ""); // no such serial number
  CHECK(device->open().find("device 64 cannot be opened") != std::string::npos);
  for (const std::vector<std::string>& words : {std::vector<std::string>{"device"},
                                                {"device", "-1"},
                                                {"device", "1x"},
                                                {"device", ""},
                                                {"device", "1", "2"}})
    CHECK(set(*device, words).find("device: expected an index") != std::string::npos);
  CHECK(set(*device, {}).find("dhd: setting nothing: expected") == 0);
  CHECK(set(*device, {"speed", "3"}).find("dhd: setting speed: expected") == 0);
  CHECK(set(*device, {"home", "now"}).find("dhd: setting home: expected") == 0);
  CHECK(set(*device, {"calibrate"}) == "");
}

#include "devices/driver.hpp"
#include "devices/haply/connection.hpp"
#include "tests/devices/haply/mock.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <string>
#include <thread>
#include <vector>

// What a session asks of the service, which device it takes, and what it leaves alone.

using namespace tactus;
using haptic::State;
using haptic::Vec3;

namespace {

std::unique_ptr<haptic::Backend> make() { return devices::find_driver("haply")->make(); }

/// Ticks like a servo's until the condition holds, half a minute at most.
template <class Condition>
bool drive_until(haptic::Backend& device, const Vec3& force, Condition holds) {
  for (int i = 0; i < 30000; ++i) {
    State state;
    const bool answered = device.read({}, state);
    CHECK(device.write(force));
    if (holds(answered, state))
      return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

std::string set(haptic::Backend& device, const std::vector<std::string>& words) {
  return device.configure(words);
}

} // namespace

TEST_CASE("the service is looked for where the environment says, whole, or else at port 10001") {
  const auto looked_for = [](const char* text) {
    setenv("TACTUS_HAPLY", text, 1);
    const devices::haply::Address address = devices::haply::default_address();
    return address.host + " " + address.port;
  };
  CHECK(looked_for("robot:99") == "robot 99");
  CHECK(looked_for("::1:99") == "::1 99");
  for (const char* half : {"", "robot", "robot:", ":99", ":"})
    CHECK(looked_for(half) == "127.0.0.1 10001");
  unsetenv("TACTUS_HAPLY");
  CHECK(devices::haply::default_address().port == "10001");
}

TEST_CASE("what a device can do, and what it is before it is opened") {
  Mock mock;
  const auto device = make();
  CHECK(device->trouble() == "");
  State state;
  CHECK_FALSE(device->read({}, state));
  REQUIRE(device->open() == "");
  const haptic::Caps caps = device->caps();
  CHECK(caps.has_velocity);
  CHECK(caps.has_buttons);
  CHECK(caps.has_rotation);
  CHECK(caps.needs_home);
  CHECK(caps.rate_hz == 1000);
  CHECK(caps.damping_limit_n_s_per_m == 6);
  CHECK(device->identity().vendor == "Haply");
  const auto listed = devices::find_driver("haply")->list();
  REQUIRE(listed.size() == 1);
  CHECK(listed[0].identity.model == "inverse3");
  CHECK(listed[0].identity.serial == "049D");
  CHECK(listed[0].state == "ready");
}

TEST_CASE("one of two devices is chosen by its number or id, and a small one has small limits") {
  Mock mock("two");
  const auto listed = devices::find_driver("haply")->list();
  REQUIRE(listed.size() == 2);
  CHECK(listed[1].index == 1);
  CHECK(listed[1].identity.model == "minverse");
  for (const char* which : {"1", "04BA"}) {
    const auto device = make();
    REQUIRE(set(*device, {"device", which}) == "");
    REQUIRE(device->open() == "");
    CHECK(device->identity().serial == "04BA");
    CHECK(device->identity().model == "minverse");
    const haptic::Caps caps = device->caps();
    CHECK(caps.peak_force_n == 4);
    CHECK(caps.stiffness_limit_n_per_m == 400);
    CHECK(caps.damping_limit_n_s_per_m == 2);
    CHECK(caps.workspace_min == Vec3{-0.04, -0.04, -0.04});
    CHECK(caps.workspace_max == Vec3{0.04, 0.04, 0.04});
    CHECK(drive_until(*device, {}, [](bool answered, const State& state) {
      return answered && norm(state.position - Vec3{0.02, 0, 0}) < 1e-12;
    }));
    CHECK(
        drive_until(*device, {9, 0, 0}, [&](bool, const State&) { return mock.report().x == 4; }));
  }
  for (const char* which : {"0", "049D"}) {
    const auto device = make();
    REQUIRE(set(*device, {"device", which}) == "");
    REQUIRE(device->open() == "");
    CHECK(device->identity().serial == "049D");
  }
  for (const char* which : {"2", "-1", "1x", "04ba"}) {
    const auto device = make();
    REQUIRE(set(*device, {"device", which}) == "");
    CHECK(device->open().find(std::string("no device ") + which + "; the first it has is 049D") !=
          std::string::npos);
  }
  CHECK(mock.report().wrong == 0);
}

TEST_CASE("an opening after the service has ended is refused, whatever was before") {
  const auto device = make();
  {
    Mock mock;
    REQUIRE(set(*device, {"service", "127.0.0.1", std::to_string(mock.port())}) == "");
    REQUIRE(device->open() == "");
    CHECK(drive_until(*device, {}, [](bool answered, const State&) { return answered; }));
    device->close();
    CHECK(drive_until(*device, {}, [](bool answered, const State&) { return !answered; }));
  }
  CHECK(device->open().find("start Haply Hub") != std::string::npos);
}

TEST_CASE("a session begins as soon as the configuration shows what was asked for, even late") {
  for (const char* kind : {"one", "late"}) {
    CAPTURE(kind);
    Mock mock(kind);
    const auto device = make();
    REQUIRE(device->open() == "");
    const Mock::Report report = mock.report();
    CHECK(report.messages >= 3); // preset, axes, and a look at both
    CHECK(report.messages < 100);
    CHECK(report.basis == "XYZ");
    CHECK(report.preset == "arm_front_centered");
    CHECK(device->caps().workspace_max == Vec3{0.15, 0.15, 0.15});
    mock.tell("place 0.01 -0.14 0.18");
    CHECK(drive_until(*device, {}, [](bool answered, const State& state) {
      return answered && norm(state.position - Vec3{0.01, 0.03, 0.02}) < 1e-12;
    }));
  }
}

TEST_CASE("a position that the service cannot place is the middle until there was a good one") {
  Mock mock("old");
  mock.tell("workspace scale 0");
  const auto device = make();
  REQUIRE(device->open() == "");
  State last;
  CHECK(drive_until(*device, {}, [&](bool answered, const State& state) {
    last = state;
    return answered;
  }));
  CHECK(norm(last.position - Vec3{0, 0.15, 0.12}) < 1e-12);
  CHECK(last.velocity == Vec3{});
  CHECK((last.flags & State::kUnreachable) != 0);
  mock.tell("workspace");
  CHECK(drive_until(*device, {}, [](bool answered, const State& state) {
    return answered && (state.flags & State::kUnreachable) == 0;
  }));
}

TEST_CASE("a mount that shows the device larger changes neither metres nor metres a second") {
  Mock mock("scaled");
  const auto device = make();
  REQUIRE(device->open() == "");
  mock.tell("place 0.01 -0.14 0.18");
  CHECK(drive_until(*device, {}, [](bool answered, const State& state) {
    return answered && norm(state.position - Vec3{0.01, 0.03, 0.02}) < 1e-12;
  }));
  CHECK(drive_until(*device, {0, 1, 0}, [&](bool, const State&) { return mock.report().z == 1; }));
}

TEST_CASE("the service is asked as often as the rate says, not more") {
  Mock mock;
  const auto device = make();
  REQUIRE(set(*device, {"rate", "50"}) == "");
  REQUIRE(device->open() == "");
  CHECK(device->caps().rate_hz == 50);
  const long before = mock.report().messages;
  const auto begun = std::chrono::steady_clock::now();
  while (mock.report().messages < before + 40)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  CHECK(std::chrono::steady_clock::now() - begun >= std::chrono::milliseconds(40 * 20 - 60));
}

TEST_CASE("a grip with a cable is a grip") {
  Mock mock("wired");
  const auto device = make();
  REQUIRE(device->open() == "");
  CHECK(drive_until(*device, {}, [](bool answered, const State& state) {
    return answered && state.buttons == 5u;
  }));
}

TEST_CASE("each setting is taken within its range and refused beyond, with what was expected") {
  const auto device = make();
  for (const char* value : {"50", "4000"})
    CHECK(set(*device, {"rate", value}) == "");
  for (const char* value : {"49.9", "4001", "nan", "1k"})
    CHECK(set(*device, {"rate", value})
              .find("rate " + std::string(value) + " is not possible: expected 50 to 4000 Hz") !=
          std::string::npos);
  for (const char* value : {"0.1", "20"})
    CHECK(set(*device, {"peak", value}) == "");
  for (const char* value : {"0.09", "20.1", "-1"})
    CHECK(set(*device, {"peak", value})
              .find("peak " + std::string(value) + " is not possible: expected 0.1 to 20 N") !=
          std::string::npos);
  for (const char* port : {"1", "65535"})
    CHECK(set(*device, {"service", "here", port}) == "");
  for (const char* port : {"0", "65536", "99.5", "x"})
    CHECK(set(*device, {"service", "here", port}).find("no whole number from 1 to 65535") !=
          std::string::npos);
  CHECK(set(*device, {}).find("haply: nothing is not understood") == 0);
  CHECK(set(*device, {"device"}) != "");
  CHECK(set(*device, {"device", "0", "1"}) != "");
  CHECK(set(*device, {"rate", "100", "200"}) != "");
}

TEST_CASE("messages that are no JSON are borne up to fifty in a row") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  for (int round = 0; round < 3; ++round) {
    const long before = mock.tell("garbage 45").messages;
    CHECK(drive_until(*device, {}, [&](bool answered, const State&) {
      return answered && mock.report().messages > before + 60;
    }));
  }
  CHECK(mock.report().sessions == 1);
  CHECK(device->trouble() == "");
  mock.tell("garbage 55");
  CHECK(drive_until(*device, {}, [&](bool, const State&) { return mock.report().sessions > 1; }));
}

TEST_CASE("an answer of up to 64 kB is read, a longer one ends the session") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  const long before = mock.tell("pad 60000").messages;
  CHECK(drive_until(*device, {}, [&](bool answered, const State&) {
    return answered && mock.report().messages > before + 20;
  }));
  CHECK(mock.report().sessions == 1);
  mock.tell("pad 66000");
  CHECK(drive_until(*device, {}, [&](bool, const State&) { return mock.report().sessions > 1; }));
  mock.tell("pad 0");
  CHECK(drive_until(*device, {}, [](bool answered, const State&) { return answered; }));
}

TEST_CASE("a service that is looked for takes no processor meanwhile") {
  const auto device = make();
  {
    Mock mock;
    REQUIRE(set(*device, {"service", "127.0.0.1", std::to_string(mock.port())}) == "");
    REQUIRE(device->open() == "");
    CHECK(drive_until(*device, {}, [](bool answered, const State&) { return answered; }));
  }
  CHECK(drive_until(*device, {}, [&](bool answered, const State&) {
    return !answered && device->trouble().find("does not answer") != std::string::npos;
  }));
  // From there on it waits for ever longer, up to 2 s.
  const std::clock_t before = std::clock();
  std::this_thread::sleep_for(std::chrono::milliseconds(800));
  CHECK(static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC < 0.08);
}

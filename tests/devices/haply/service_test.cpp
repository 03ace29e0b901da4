#include "devices/haply/connection.hpp"
#include "tests/devices/haply/mock.hpp"

#include <chrono>
#include <ctime>
#include <string>
#include <thread>

// What a session asks of the service, which device it takes, and what it leaves alone.

using namespace tactus;
using haptic::State;

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

TEST_CASE("what a device can do: careful limits, around the middle that the preset sets") {
  Mock mock;
  const auto device = make();
  CHECK(device->trouble() == "");
  State state;
  CHECK_FALSE(device->read({}, state));
  REQUIRE(device->open() == "");
  const haptic::Caps caps = device->caps();
  CHECK(caps.latency_ticks == 1); // a message carries a force there and a state back
  CHECK(caps.peak_force_n == 5);
  CHECK(caps.continuous_force_n == 1.25);
  CHECK(caps.stiffness_limit_n_per_m == 300);
  CHECK(caps.damping_limit_n_s_per_m == 2);
  CHECK(caps.workspace_min == Vec3{-0.1, -0.1, -0.1});
  CHECK(caps.workspace_max == Vec3{0.1, 0.1, 0.1});
  CHECK(caps.rate_hz == 1000);
  CHECK((caps.has_velocity && caps.has_buttons && caps.has_rotation && caps.needs_home));
  CHECK(device->identity().vendor == "Haply");
  const auto listed = devices::find_driver("haply")->list();
  REQUIRE(listed.size() == 1);
  CHECK(listed[0].identity.model == "inverse3");
  CHECK(listed[0].identity.serial == "049D");
  CHECK(listed[0].state == "ready");
}

TEST_CASE(
    "without presets the origin is the base's; what cannot be placed is the middle at first") {
  Mock mock("old");
  mock.tell("workspace scale 0");
  const auto device = make();
  REQUIRE(device->open() == "");
  const haptic::Caps caps = device->caps();
  CHECK(norm((caps.workspace_min + caps.workspace_max) * 0.5 - Vec3{0, 0.15, 0.12}) < 1e-12);
  State last;
  CHECK(drive_until(*device, {}, [&](bool answered, const State& state) {
    last = state;
    return answered;
  }));
  CHECK(norm(last.position - Vec3{0, 0.15, 0.12}) < 1e-12);
  CHECK(last.velocity == Vec3{});
  CHECK((last.flags & State::kUnreachable) != 0);
  mock.tell("workspace");
  mock.tell("place 0.01 -0.14 0.18");
  CHECK(drive_until(*device, {}, at({0.01, 0.18, 0.14})));
  CHECK(drive_until(*device, {1, 0, 0}, [&](bool, const State&) { return mock.report().x == 1; }));
  CHECK(mock.report().wrong == 0); // an older service, and the force by its key
}

TEST_CASE("a session that has ended leaves a device that is neither read nor opened") {
  const auto device = make();
  {
    Mock mock = Mock::alone();
    REQUIRE(set(*device, {"service", "127.0.0.1", std::to_string(mock.port())}) == "");
    REQUIRE(device->open() == "");
    CHECK(drive_until(*device, {}, alive));
    device->close();
    CHECK(drive_until(*device, {}, silent));
  }
  CHECK(device->open().find("start Haply Hub") != std::string::npos);
}

TEST_CASE("messages without JSON are borne up to fifty in a row, answers up to 64 kB") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  const auto goes_on = [&](const char* fault) {
    const long before = mock.tell(fault).messages;
    return drive_until(*device, {}, [&](bool answered, const State&) {
      return answered && mock.report().messages > before + 60;
    });
  };
  for (const char* fault : {"garbage 45", "garbage 45", "garbage 45", "pad 60000"})
    CHECK(goes_on(fault));
  CHECK(mock.report().sessions == 1);
  CHECK(device->trouble() == "");
  for (const char* fault : {"pad 66000", "garbage 55"}) {
    const long before = mock.tell(fault).sessions;
    CHECK(drive_until(*device, {},
                      [&](bool, const State&) { return mock.report().sessions > before; }));
    mock.tell("pad 0");
    CHECK(drive_until(*device, {}, alive));
  }
  mock.tell("garbage 100000");
  CHECK(drive_until(*device, {}, [&](bool, const State&) {
    return device->trouble().find("stopped sending JSON") != std::string::npos;
  }));
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
    CHECK(caps.continuous_force_n == 1);
    CHECK(caps.stiffness_limit_n_per_m == 300);
    CHECK(caps.damping_limit_n_s_per_m == 2);
    CHECK(caps.workspace_min == Vec3{-0.04, -0.04, -0.04});
    CHECK(caps.workspace_max == Vec3{0.04, 0.04, 0.04});
    CHECK(drive_until(*device, {}, at({0.02, 0, 0})));
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
    CHECK(device->open().find(std::string("device ") + which +
                              ": not found by Haply's service; its first device is 049D") !=
          std::string::npos);
  }
  CHECK(mock.report().wrong == 0);
}

TEST_CASE("a session begins as soon as the configuration shows what was asked for, even late, and "
          "at any scale") {
  for (const char* kind : {"one", "late", "scaled"}) { // a mount may show the device larger
    CAPTURE(kind);
    Mock mock(kind);
    const auto device = make();
    REQUIRE(device->open() == "");
    const Mock::Report report = mock.report();
    CHECK(report.messages >= 3); // preset, axes, and a look at both
    CHECK(report.messages < 100);
    CHECK(report.basis == "XYZ");
    CHECK(report.preset == "arm_front_centered");
    mock.tell("place 0.01 -0.14 0.18");
    CHECK(drive_until(*device, {}, at({0.01, 0.03, 0.02})));
    CHECK(
        drive_until(*device, {0, 1, 0}, [&](bool, const State&) { return mock.report().z == 1; }));
  }
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

TEST_CASE("each setting is taken within its range and refused beyond, with what was expected") {
  const auto device = make();
  const auto refused = [&](const char* name, std::initializer_list<const char*> values,
                           const char* expected) {
    for (const char* value : values)
      CHECK(set(*device, {name, value}).find(expected) != std::string::npos);
  };
  for (const char* value : {"50", "4000"})
    CHECK(set(*device, {"rate", value}) == "");
  refused("rate", {"49.9", "4001", "nan", "1k"}, "expected 50..4000 Hz");
  for (const char* value : {"0.1", "20"})
    CHECK(set(*device, {"peak", value}) == "");
  refused("peak", {"0.09", "20.1"}, "expected 0.1..20 N");
  for (const char* port : {"1", "65535"})
    CHECK(set(*device, {"service", "here", port}) == "");
  for (const char* port : {"0", "65536", "99.5", "x"})
    CHECK(set(*device, {"service", "here", port}).find("expected 1..65535") != std::string::npos);
  CHECK(set(*device, {}).find("haply: setting nothing: expected") == 0);
  CHECK(set(*device, {"device", "0", "1"}) != "");
}

TEST_CASE("a service that is looked for takes no processor meanwhile") {
  const auto device = make();
  {
    Mock mock = Mock::alone();
    REQUIRE(set(*device, {"service", "127.0.0.1", std::to_string(mock.port())}) == "");
    REQUIRE(device->open() == "");
    CHECK(drive_until(*device, {}, alive));
  }
  CHECK(drive_until(*device, {}, [&](bool answered, const State&) {
    return !answered && device->trouble().find("does not answer") != std::string::npos;
  }));
  // From there on it waits for ever longer, up to 2 s.
  const std::clock_t before = std::clock();
  std::this_thread::sleep_for(std::chrono::milliseconds(800));
  CHECK(static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC < 0.08);
}

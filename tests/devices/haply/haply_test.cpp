#include "tests/devices/cancelled_opening.hpp"
#include "tests/devices/haply/mock.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <thread>

using namespace tactus;
using haptic::State;

TEST_CASE("the handle is read in the project's axes, and a force moves it") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  CHECK(device->identity().serial == "049D");
  CHECK(device->identity().model == "inverse3");
  CHECK(device->trouble() == "");
  mock.tell("place 0.01 -0.14 0.18"); // from the base; the middle is at 0 -0.12 0.15
  CHECK(drive_until(*device, {}, at({0.01, 0.03, 0.02})));
  State last;
  CHECK(drive_until(*device, {0, 1, 0}, [&last](bool answered, const State& state) {
    last = state;
    return answered && state.position.y > 0.031;
  }));
  CHECK(last.velocity.y > 0);
  CHECK(last.position.x == doctest::Approx(0.01));
  CHECK(last.buttons == 2);
  CHECK(last.rotation.y == doctest::Approx(std::acos(0.0)));
  CHECK((last.flags & State::kHomed) != 0);
  Mock::Report report;
  CHECK(drive_until(*device, {0, 1, 0}, [&](bool, const State&) {
    report = mock.report();
    return report.z == 1; // up
  }));
  CHECK(report.wrong == 0);
  CHECK(report.profile == "tactus");
  CHECK(report.basis == "XYZ");
  CHECK(report.preset == "arm_front_centered");
}

TEST_CASE("what navigation does to the workspace changes neither metres nor directions") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  mock.tell("workspace scale 2.5 quarter offset 1 2 3");
  mock.tell("place 0.01 -0.14 0.18");
  CHECK(drive_until(*device, {}, at({0.01, 0.03, 0.02})));
  CHECK(drive_until(*device, {1, 2, 3}, [&](bool, const State&) {
    const Mock::Report report = mock.report(); // what the device itself feels, the service's axes
    return norm(Vec3{report.x, report.y, report.z} - Vec3{1, -3, 2}) < 1e-9;
  }));
  State last;
  CHECK(drive_until(*device, {0, 1, 0}, [&last](bool, const State& state) {
    last = state;
    return state.velocity.y > 0.01;
  }));
  mock.tell("workspace scale 0");
  CHECK(drive_until(*device, {0, 1, 0}, [](bool, const State& state) {
    return (state.flags & State::kUnreachable) != 0;
  }));
  CHECK(drive_until(*device, {0, 1, 0}, [&](bool, const State&) { return mock.report().z == 0; }));
}

TEST_CASE("the force ends with the servo, and with the device") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  REQUIRE(
      drive_until(*device, {1, 0, 0}, [&](bool, const State&) { return mock.report().x == 1; }));
  bool fell = false; // nobody writes any more
  for (int i = 0; i < 5000 && !fell; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    fell = mock.report().x == 0;
  }
  CHECK(fell);
  const auto returned = std::chrono::steady_clock::now();
  REQUIRE(
      drive_until(*device, {1, 0, 0}, [&](bool, const State&) { return mock.report().x == 1; }));
  CHECK(std::chrono::steady_clock::now() - returned > std::chrono::milliseconds(95)); // softly
  device->close();
  CHECK(mock.report().x == 0);
  REQUIRE(device->open() == "");
  CHECK(drive_until(*device, {}, alive));
}

TEST_CASE("a peak is kept, and what is no number is no force") {
  Mock mock;
  const auto device = make();
  REQUIRE(set(*device, {"peak", "0.5"}) == "");
  REQUIRE(device->open() == "");
  CHECK(device->caps().peak_force_n == 0.5);
  CHECK(drive_until(*device, {3, 4, 0}, [&](bool, const State&) {
    const Mock::Report report = mock.report();
    return std::abs(report.x - 0.3) < 1e-12 && std::abs(report.z - 0.4) < 1e-12;
  }));
  CHECK(
      drive_until(*device, {NAN, 0, 0}, [&](bool, const State&) { return mock.report().z == 0; }));
}

TEST_CASE("an uncalibrated device gets no force and says so") {
  Mock mock;
  mock.tell("calibrated 0");
  CHECK(devices::find_driver("haply")->list().at(0).state == "not calibrated");
  const auto device = make();
  REQUIRE(device->open() == "");
  for (int i = 0; i < 50; ++i)
    CHECK(drive_until(*device, {1, 1, 1}, alive));
  const Mock::Report report = mock.report();
  CHECK(report.x == 0);
  CHECK(report.y == 0);
  CHECK(device->trouble().find("calibrated") != std::string::npos);
  mock.tell("calibrated 1");
  CHECK(drive_until(*device, {1, 0, 0}, [&](bool, const State&) { return mock.report().x == 1; }));
  CHECK(device->trouble() == "");
}

TEST_CASE("a service that hangs up, ends and starts again is found again, and so is an unplugged "
          "device") {
  const auto device = make();
  int port = 0;
  {
    Mock mock = Mock::alone();
    port = mock.port();
    REQUIRE(set(*device, {"service", "127.0.0.1", std::to_string(port)}) == "");
    REQUIRE(device->open() == "");
    REQUIRE(drive_until(*device, {}, alive));
    mock.tell("drop"); // hangs up once
    CHECK(drive_until(*device, {}, [&](bool, const State&) { return mock.report().sessions > 1; }));
    CHECK(drive_until(*device, {}, alive));
  }
  CHECK(drive_until(*device, {1, 0, 0}, [&](bool answered, const State&) {
    return !answered && device->trouble().find("systemctl") != std::string::npos;
  }));
  Mock again = Mock::alone(port);
  CHECK(drive_until(*device, {}, alive));
  CHECK(device->trouble() == "");
  again.tell("unplug");
  CHECK(drive_until(*device, {}, silent));
  again.tell("plug");
  CHECK(drive_until(*device, {}, alive));
  again.tell("quiet");
  CHECK(drive_until(*device, {}, silent));
}

TEST_CASE("no service, no device, a wrong device and another server are four sentences") {
  std::array<std::string, 4> refusals;
  setenv("TACTUS_HAPLY", "127.0.0.1:1", 1);
  CHECK(devices::find_driver("haply")->problem().find("Haply Hub") != std::string::npos);
  CHECK(devices::find_driver("haply")->list().empty());
  refusals[0] = make()->open();
  CHECK(refusals[0].find("start Haply Hub") != std::string::npos);
  {
    Mock mock("empty");
    CHECK(devices::find_driver("haply")->problem() == "");
    refusals[1] = make()->open();
    CHECK(refusals[1].find("no Inverse3") != std::string::npos);
  }
  {
    Mock mock;
    const auto device = make();
    REQUIRE(set(*device, {"device", "FFFF"}) == "");
    refusals[2] = device->open();
    CHECK(refusals[2].find("049D") != std::string::npos);
  }
  Mock mock("prose");
  refusals[3] = make()->open();
  CHECK(refusals[3].find("not Haply's service") != std::string::npos);
}

TEST_CASE("an opening that waits for a service is cancelled") {
  setenv("TACTUS_HAPLY", "127.0.0.1:1", 1);
  const auto device = make();
  CHECK(cancelled_opening(*device).find("cancelled") != std::string::npos);
}

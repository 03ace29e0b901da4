#include "devices/driver.hpp"
#include "tests/devices/haply/mock.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

using namespace tactus;
using haptic::State;
using haptic::Vec3;

namespace {

std::unique_ptr<haptic::Backend> make() {
  const devices::Driver* driver = devices::find_driver("haply");
  REQUIRE(driver != nullptr);
  return driver->make();
}

void wait_1ms() { std::this_thread::sleep_for(std::chrono::milliseconds(1)); }

/// Ticks like a servo's, each asking for this force, until the condition holds; half a minute at
/// most. False when it never did.
template <class Condition>
bool drive_until(haptic::Backend& device, const Vec3& force, Condition holds) {
  for (int i = 0; i < 30000; ++i) {
    State state;
    const bool answered = device.read({}, state);
    CHECK(device.write(force));
    if (holds(answered, state))
      return true;
    wait_1ms();
  }
  return false;
}

bool alive(bool answered, const State&) { return answered; }

} // namespace

TEST_CASE("the handle is read in the project's axes, and a force moves it") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  CHECK(device->identity().serial == "049D");
  CHECK(device->identity().model == "inverse3");
  CHECK(device->trouble() == "");
  mock.tell("place 0.01 -0.14 0.18"); // from the base; the middle is at 0 -0.12 0.15
  CHECK(drive_until(*device, {}, [](bool answered, const State& state) {
    return answered && norm(state.position - Vec3{0.01, 0.03, 0.02}) < 1e-12;
  }));
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

TEST_CASE("the maker's limits are the defaults, around the middle that the preset sets") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  const haptic::Caps caps = device->caps();
  CHECK(caps.latency_ticks == 1); // a message carries a force there and a state back
  CHECK(caps.peak_force_n == 10);
  CHECK(caps.stiffness_limit_n_per_m == 1000);
  CHECK(caps.workspace_min == Vec3{-0.15, -0.15, -0.15});
  CHECK(caps.workspace_max == Vec3{0.15, 0.15, 0.15});
}

TEST_CASE(
    "a service without presets leaves the origin in the base, and the workspace in front of it") {
  Mock mock("old");
  const auto device = make();
  REQUIRE(device->open() == "");
  const haptic::Caps caps = device->caps();
  CHECK(norm((caps.workspace_min + caps.workspace_max) * 0.5 - Vec3{0, 0.15, 0.12}) < 1e-12);
  mock.tell("place 0.01 -0.14 0.18");
  CHECK(drive_until(*device, {}, [](bool answered, const State& state) {
    return answered && norm(state.position - Vec3{0.01, 0.18, 0.14}) < 1e-12;
  }));
  CHECK(mock.report().wrong == 0);
}

TEST_CASE("what navigation does to the workspace changes neither metres nor directions") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  mock.tell("workspace scale 2.5 quarter offset 1 2 3");
  mock.tell("place 0.01 -0.14 0.18");
  CHECK(drive_until(*device, {}, [](bool answered, const State& state) {
    return answered && norm(state.position - Vec3{0.01, 0.03, 0.02}) < 1e-9;
  }));
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
    wait_1ms();
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
  const std::array<std::string, 2> peak{"peak", "0.5"};
  REQUIRE(device->configure(peak) == "");
  REQUIRE(device->open() == "");
  CHECK(device->caps().peak_force_n == 0.5);
  CHECK(drive_until(*device, {3, 4, 0}, [&](bool, const State&) {
    const Mock::Report report = mock.report();
    return std::abs(report.x - 0.3) < 1e-12 && std::abs(report.z - 0.4) < 1e-12;
  }));
  CHECK(
      drive_until(*device, {NAN, 0, 0}, [&](bool, const State&) { return mock.report().z == 0; }));
}

TEST_CASE("messages that are no JSON change nothing; too many of them end the session") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  mock.tell("garbage 5");
  for (int i = 0; i < 10; ++i)
    wait_1ms();
  CHECK(drive_until(*device, {}, alive));
  CHECK(mock.report().sessions == 1);
  mock.tell("garbage 100000");
  CHECK(drive_until(*device, {}, [&](bool, const State&) {
    return device->trouble().find("no JSON") != std::string::npos;
  }));
  mock.tell("garbage 0");
  CHECK(drive_until(*device, {}, alive));
  CHECK(mock.report().sessions > 1);
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

TEST_CASE("a service that hangs, ends and starts again is found again") {
  const auto device = make();
  int port = 0;
  {
    Mock mock;
    port = mock.port();
    const std::array<std::string, 3> service{"service", "127.0.0.1", std::to_string(port)};
    REQUIRE(device->configure(service) == "");
    REQUIRE(device->open() == "");
    REQUIRE(drive_until(*device, {}, alive));
    mock.tell("drop"); // hangs up once
    CHECK(drive_until(*device, {}, [&](bool, const State&) { return mock.report().sessions > 1; }));
    CHECK(drive_until(*device, {}, alive));
  }
  CHECK(drive_until(*device, {1, 0, 0}, [&](bool answered, const State&) {
    return !answered && device->trouble().find("systemctl") != std::string::npos;
  }));
  Mock again("one", port);
  CHECK(drive_until(*device, {}, alive));
  CHECK(device->trouble() == "");
  again.tell("quiet");
  CHECK(drive_until(*device, {}, [](bool answered, const State&) { return !answered; }));
}

TEST_CASE("an unplugged device falls silent and returns") {
  Mock mock;
  const auto device = make();
  REQUIRE(device->open() == "");
  mock.tell("unplug");
  CHECK(drive_until(*device, {}, [](bool answered, const State&) { return !answered; }));
  mock.tell("plug");
  CHECK(drive_until(*device, {}, alive));
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
    const std::array<std::string, 2> other{"device", "FFFF"};
    REQUIRE(device->configure(other) == "");
    refusals[2] = device->open();
    CHECK(refusals[2].find("049D") != std::string::npos);
  }
  Mock mock("prose");
  refusals[3] = make()->open();
  CHECK(refusals[3].find("not Haply's service") != std::string::npos);
}

TEST_CASE("settings are checked") {
  const auto device = make();
  const auto refused = [&](std::initializer_list<std::string> words) {
    const std::vector<std::string> all(words);
    return device->configure(all) != "";
  };
  CHECK(refused({"rate", "9"}));
  CHECK(refused({"rate", "fast"}));
  CHECK(refused({"peak", "21"}));
  CHECK(refused({"peak", "nan"}));
  CHECK(refused({"service", "localhost", "0"}));
  CHECK(refused({"service", "localhost"}));
  CHECK(refused({"colour", "red"}));
  CHECK(refused({}));
  CHECK_FALSE(refused({"rate", "500"}));
  CHECK_FALSE(refused({"service", "localhost", "10001"}));
}

TEST_CASE("an opening that waits for a service is cancelled") {
  setenv("TACTUS_HAPLY", "127.0.0.1:1", 1);
  const auto device = make();
  std::string sentence;
  std::atomic<bool> opened{false};
  std::thread opening([&] {
    sentence = device->open();
    opened = true;
  });
  wait_1ms();
  const auto asked = std::chrono::steady_clock::now();
  while (!opened) {
    device->cancel();
    wait_1ms();
  }
  opening.join();
  CHECK(std::chrono::steady_clock::now() - asked < std::chrono::milliseconds(600));
  CHECK(sentence.find("cancelled") != std::string::npos);
}

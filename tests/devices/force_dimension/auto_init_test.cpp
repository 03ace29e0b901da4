#include "tests/devices/force_dimension/fake.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

// The maker's automatic initialisation (drdAutoInit), which moves the handle by its motors.

using namespace tactus;

namespace {

const std::vector<std::string> kHome{"home"};

struct Robot : Fake {
  explicit Robot(const char* mode = "sigma.7") : Fake(mode, FAKE_DRD) {}
  /// Being driven, interrupted, positions asked for meanwhile.
  std::array<int, 3> driven() const {
    std::array<int, 3> all{};
    state_of(all.data());
    return all;
  }
  void (*state_of)(int*) = hook<void(int*)>("fake_drd_state");
  void (*end)() = hook<void()>("fake_drd_end");
};

/// Ticks of a servo until that holds, ten seconds at most; the last state.
template <class Holds> State drive_until(haptic::Backend& device, const Holds& holds) {
  State state;
  for (int i = 0; i < 10000 && !holds(); ++i) {
    CHECK(device.read({}, state));
    static_cast<void>(device.write({}));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  REQUIRE(holds());
  CHECK(device.read({}, state));
  return state;
}

} // namespace

TEST_CASE("home lets the device initialise itself, without a call of the servo meanwhile") {
  const Robot robot;
  const auto device = make();
  REQUIRE(device->open() == "");
  robot.set_position(0.01, 0.02, 0.03);
  robot.set(0, 0, 1, 0); // it needs it
  State state = drive(*device, {}, 70);
  const Vec3 before = state.position;
  CHECK(state.flags == 0);
  CHECK(device->trouble().find("send home") != std::string::npos);
  CHECK(robot.driven()[0] == 0); // not before that: it moves by itself

  REQUIRE(device->configure(kHome) == "");
  CHECK(device->configure(kHome).find("already") != std::string::npos);
  state = drive_until(*device, [&] { return robot.driven()[0] == 1; });
  CHECK(state.flags == 0);
  CHECK(state.position == before);
  for (int i = 0; i < 100; ++i) {
    CHECK(device->read({}, state));
    CHECK_FALSE(device->write({1, 0, 0}));
    CHECK(device->write({}));
  }
  CHECK(robot.driven()[2] == 0);
  CHECK(robot.force() == Vec3{});

  robot.end();
  drive_until(*device, [&] { return robot.driven()[0] == 0; });
  state = drive_until(*device, [&] { return device->trouble().empty(); });
  CHECK((state.flags & State::kHomed) != 0);
  drive(*device, {1, 0, 0}, 200);
  CHECK(robot.force().y > 0);      // rises over 0.1 s; the library's y is the project's x
  CHECK(robot.counts()[2] == 240); // the watchdog is set again
  REQUIRE(device->configure(kHome) == "");
}

TEST_CASE("a way that is not free is told with the library's reason, and home tries again") {
  const Robot robot("stuck");
  const auto device = make();
  REQUIRE(device->open() == "");
  REQUIRE(device->configure(kHome) == "");
  robot.end();
  drive_until(*device,
              [&] { return device->trouble().find("no device found") != std::string::npos; });
  CHECK((drive(*device, {}, 1).flags & State::kFault) == 0);
  CHECK(device->configure(kHome) == "");
}

TEST_CASE("a device that drives itself, or is about to, is closed at once, and the motors stop") {
  for (const char* mode : {"sigma.7", "slow"}) {
    CAPTURE(mode);
    const Robot robot(mode);
    {
      const auto device = make();
      REQUIRE(device->open() == "");
      REQUIRE(robot.counts()[0] == 1);
      REQUIRE(device->configure(kHome) == "");
      if (std::string(mode) == "slow")
        drive(*device, {}, 2);
      else
        drive_until(*device, [&] { return robot.driven()[0] == 1; });
    }
    for (int i = 0; i < 10000 && robot.counts()[0] > 0; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    CHECK(robot.counts()[0] == 0);
    CHECK(robot.driven()[1] == 1);
  }
}

TEST_CASE("a home that no servo has begun ends with the closing") {
  const Robot robot;
  const auto device = make();
  REQUIRE(device->open() == "");
  REQUIRE(device->configure(kHome) == "");
  device->close();
  CHECK(robot.counts()[0] == 0);
  REQUIRE(device->open() == "");
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  drive(*device, {}, 10);
  CHECK(robot.driven()[0] == 0);
}

TEST_CASE("a device that cannot do that waits for its calibration") {
  const Robot robot("plain");
  const auto device = make();
  REQUIRE(device->open() == "");
  REQUIRE(device->configure(kHome) == "");
  drive(*device, {}, 70);
  CHECK(robot.driven()[0] == 0);
  CHECK(device->trouble().find("calibration pole") != std::string::npos);
}

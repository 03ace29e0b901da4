#include "tests/devices/openhaptics/fake.hpp"

#include <doctest/doctest.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

using namespace tactus;
using haptic::State;

TEST_CASE(
    "the handle's place, angles and buttons come, and a force, sent inside frames, moves it") {
  const auto [fake, device] = Opened();
  CHECK(device->owns_thread());
  CHECK(device->identity().vendor == "SensAble");
  CHECK(device->identity().model == "PHANTOM Omni");
  CHECK(device->identity().serial == "F-0042");
  CHECK(fake.counts()[3] == 1); // force is on, and the vendor's own clamp and ramp
  CHECK(fake.counts()[4] == 1);
  CHECK(fake.more().ramping == 1);
  CHECK(fake.more().rate_hz == 1000);
  CHECK(device->caps().workspace_min == Vec3{-0.08, -0.06, -0.035});
  Session session(*device);
  haptic::Report report = session.after(300);
  CHECK(norm(report.state.position - Vec3{0.01, 0.02, -0.03}) < 1e-12); // mm there
  CHECK(report.state.rotation == Vec3{-0.2, -0.1, -0.3});
  session.ask({0.5, 0, 0});
  report = session.after(100);
  CHECK(fake.force() == Vec3{0.5, 0, 0});
  CHECK(report.state.position.x > 0.011);
  CHECK(report.state.velocity.x > 0);
  CHECK(fake.counts()[1] == 0);
  CHECK(device->trouble() == "");
  fake.press(2);
  CHECK(session.after(2).state.buttons == 2);
  const std::array<std::string, 1> home{"home"}; // lets the library calibrate again
  const unsigned long before = fake.counts()[5];
  CHECK(device->configure(home) == "");
  session.after(10);
  CHECK(fake.counts()[5] == before + 1);
}

TEST_CASE("halting and closing leave zero force, and the device opens again") {
  const Fake fake;
  const auto device = make();
  for (int round = 0; round < 3; ++round) {
    REQUIRE(device->open() == "");
    {
      Session session(*device);
      session.ask({1, 0, 0});
      session.after(300);
    }
    CHECK(fake.force() == Vec3{});
    const auto frames = fake.counts()[0];
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    CHECK(fake.counts()[0] == frames); // nobody calls any more
    device->close();
    CHECK(fake.counts()[2] == 0);
    CHECK(fake.counts()[3] == 0);
  }
}

TEST_CASE("a library that is missing, incomplete, loaded twice or without a device is told") {
  is_told_of_its_library<Fake>("install", FAKE_HD_INCOMPLETE, "hdSetDoublev");
  is_loaded_and_opened_once<Fake>("F-0042", "FAKE_HD_LOADS");
  opens_in_vain<Fake>("dead", "cable and power");
  opens_in_vain<Fake>("dead", "Default Device, Default PHANToM, no name");
  const Fake licence("licence");
  says(make()->open(), "licence");
  const Fake silent("silent");
  says(make()->open(), "account");
}

TEST_CASE(
    "other default names are tried; a name of several words and the default may be asked for") {
  {
    const Fake fake("second");
    CHECK(make()->open() == "");
  }
  const Fake fake("named");
  const auto device = make();
  const auto set = [&](const std::vector<std::string>& words) { return device->configure(words); };
  CHECK(device->open() != "");
  CHECK(set({"device", "Left", "Device"}) == "");
  CHECK(device->open() == "");
  device->close();
  CHECK(set({"device", "0"}) == "");
  CHECK(device->open().find("names Default Device") != std::string::npos);
  CHECK(set({"device"}).find("expected the name") != std::string::npos);
  CHECK(set({}).find("openhaptics: setting nothing: expected") == 0);
  CHECK(set({"speed", "3"}).find("openhaptics: setting speed: expected") == 0);
  CHECK(set({"home", "now"}).find("openhaptics: setting home: expected") == 0);
  CHECK(set({"calibrate"}) == "");
}

TEST_CASE("a scheduler that does not start is refused") {
  const auto [fake, device] = Opened("no scheduler");
  CHECK_FALSE(device->run([](void*) {}, nullptr));
}

TEST_CASE("a PHANTOM with six motors is sent torque inside frames, once it was asked for it") {
  const auto [fake, device] = Opened("6dof");
  CHECK(device->caps().peak_torque_n_m == doctest::Approx(0.188));
  double torque[3] = {};
  {
    Session session(*device);
    session.after(300);
    CHECK(fake.torque_of(torque) == 0);
    session.servo.exchange().wrist.write({true, {{0.01, -0.02, 0.3}, 5}});
    session.after(300);
    CHECK(fake.torque_of(torque) > 0);
    const Vec3 sent = Vec3{torque[0], torque[1], torque[2]} * 1e-3;
    CHECK(norm(sent) == doctest::Approx(0.188)); // the device's peak
    CHECK(sent.x > 0);
    CHECK(sent.y < 0);
    CHECK(fake.counts()[1] == 0);
    CHECK(norm(session.after(1).wrist.torque_n_m) == doctest::Approx(0.188));
    session.servo.exchange().wrist.write({false, {}});
    session.after(20);
    fake.torque_of(torque);
    CHECK(torque[2] == 0);
    session.servo.exchange().wrist.write({true, {{0, 0, 0.1}, 0}});
    session.after(100);
    fake.torque_of(torque);
    CHECK(torque[2] != 0);
  }
  fake.torque_of(torque); // halted
  CHECK(torque[2] == 0);
}

TEST_CASE("one with three motors is sent no torque whatever is asked") {
  const auto [fake, device] = Opened();
  CHECK(device->caps().peak_torque_n_m == 0);
  Session session(*device);
  session.servo.exchange().wrist.write({true, {{0, 0, 0.1}, 1}});
  session.after(300);
  double torque[3] = {};
  CHECK(fake.torque_of(torque) == 0);
}

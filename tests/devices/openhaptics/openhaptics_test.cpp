#include "tests/devices/cancelled_opening.hpp"
#include "tests/devices/openhaptics/fake.hpp"

#include <doctest/doctest.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>

using namespace tactus;
using haptic::State;

TEST_CASE("five hundred callbacks bring positions in millimetres as normalised ones") {
  const Fake fake;
  const auto device = make();
  REQUIRE(device->open() == "");
  CHECK(device->owns_thread());
  CHECK(device->identity().model == "PHANTOM Omni");
  CHECK(device->identity().serial == "F-0042");
  const haptic::Caps caps = device->caps();
  CHECK(caps.workspace_min == haptic::Vec3{-0.08, -0.06, -0.035});
  const haptic::Workspace workspace{caps.workspace_min, caps.workspace_max};
  Session session(*device);
  const haptic::Report report = session.after(500);
  CHECK(report.tick.index >= 500);
  const haptic::Vec3 share = workspace.normalised(report.state.position);
  CHECK(share.x == doctest::Approx(90.0 / 160));
  CHECK(share.y == doctest::Approx(80.0 / 120));
  CHECK(share.z == doctest::Approx(5.0 / 70));
  CHECK(report.state.rotation == haptic::Vec3{-0.2, -0.1, -0.3});
  CHECK((report.state.flags & State::kHomed) != 0);
  CHECK(device->trouble() == "");
  CHECK(fake.counts()[4] == 1); // the vendor's own clamp is on
}

TEST_CASE("a force moves the handle, arrives in newtons and is sent inside frames only") {
  const Fake fake;
  const auto device = make();
  REQUIRE(device->open() == "");
  Session session(*device);
  const double before = session.after(300).state.position.x;
  session.ask({0.5, 0, 0});
  const haptic::Report report = session.after(100);
  CHECK(fake.force() == haptic::Vec3{0.5, 0, 0});
  CHECK(report.state.position.x > before + 1e-3);
  CHECK(report.state.velocity.x > 0);
  CHECK(fake.counts()[1] == 0);
  fake.press(2);
  CHECK(session.after(2).state.buttons == 2);
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
    CHECK(fake.force() == haptic::Vec3{});
    const auto frames = fake.counts()[0];
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    CHECK(fake.counts()[0] == frames); // nobody calls any more
    device->close();
    CHECK(fake.counts()[2] == 0);
    CHECK(fake.counts()[3] == 0);
  }
}

TEST_CASE("limits come from the device, else from the table, else the least of all") {
  {
    const Fake fake;
    const auto device = make();
    REQUIRE(device->open() == "");
    CHECK(device->caps().peak_force_n == doctest::Approx(3.4));
    CHECK(device->caps().continuous_force_n == doctest::Approx(0.9));
    CHECK(device->caps().stiffness_limit_n_per_m == doctest::Approx(500));
    CHECK(device->caps().damping_limit_n_s_per_m == doctest::Approx(5)); // the Omni's, of the table
  }
  const Fake fake("dumb");
  const auto device = make();
  REQUIRE(device->open() == "");
  CHECK(device->caps().peak_force_n == doctest::Approx(3.3));
  CHECK(device->caps().continuous_force_n == doctest::Approx(0.88));
  CHECK(device->caps().stiffness_limit_n_per_m == doctest::Approx(700));
}

TEST_CASE("no library, a missing function and a device that does not open are three sentences") {
  unsetenv("FAKE_HD");
  setenv("PHANTOM_LIBHD", "/nowhere/libHD.so", 1);
  const std::string absent = make()->open();
  CHECK(absent.find("/nowhere/libHD.so") != std::string::npos);
  CHECK(absent.find("install") != std::string::npos);
  CHECK(devices::find_driver("openhaptics")->problem() != "");
  CHECK(devices::find_driver("openhaptics")->list().empty());

  setenv("PHANTOM_LIBHD", FAKE_HD_INCOMPLETE, 1);
  const std::string incomplete = make()->open();
  CHECK(incomplete.find("hdSetDoublev") != std::string::npos);

  std::string refusals[3];
  const char* const modes[] = {"dead", "licence", "silent"};
  for (int i = 0; i < 3; ++i) {
    const Fake fake(modes[i]);
    refusals[i] = make()->open();
  }
  CHECK(refusals[0].find("cable and power") != std::string::npos);
  CHECK(refusals[1].find("licence") != std::string::npos);
  CHECK(refusals[2].find("account") != std::string::npos);
  CHECK(refusals[0].find("Default PHANToM") != std::string::npos);
  CHECK(refusals[0] != refusals[2]);
  CHECK(absent != incomplete);
}

TEST_CASE("other default names are tried, and a name may be asked for") {
  {
    const Fake fake("second");
    CHECK(make()->open() == "");
  }
  const Fake fake("named");
  const auto device = make();
  CHECK(device->open() != "");
  const std::array<std::string, 3> words{"device", "Left", "Device"};
  CHECK(device->configure(words) == "");
  CHECK(device->open() == "");
  const std::array<std::string, 2> other{"speed", "3"};
  CHECK(device->configure(other).find("speed") != std::string::npos);
}

TEST_CASE("warm motors are told; a speeding handle loses its force until none has been asked") {
  const Fake fake;
  const auto device = make();
  REQUIRE(device->open() == "");
  Session session(*device);
  session.after(300);
  fake.fail(0x0200);
  CHECK((session.after(20).state.flags & State::kMotorsHot) != 0);
  CHECK(device->trouble().find("warm") != std::string::npos);
  session.ask({0.5, 0, 0});
  session.after(20);
  fake.fail(0x0200); // and a worse one
  fake.fail(0x0203);
  const haptic::Report report = session.after(20);
  CHECK((report.state.flags & State::kFault) != 0);
  CHECK((report.state.flags & State::kMotorsHot) != 0);
  CHECK(report.latched);
  CHECK(device->trouble().find("motors 1") != std::string::npos);
  CHECK(fake.force() == haptic::Vec3{});
  session.after(300);
  CHECK((session.after(1).state.flags & State::kFault) == 0);
  CHECK(fake.counts()[3] == 1);
  session.servo.exchange().motors.enable();
  session.ask({0.5, 0, 0});
  session.after(20);
  CHECK(fake.force().x == doctest::Approx(0.5));
}

TEST_CASE("home lets the library calibrate again") {
  const Fake fake;
  const auto device = make();
  REQUIRE(device->open() == "");
  Session session(*device);
  session.after(300);
  const unsigned long before = fake.counts()[5];
  const std::array<std::string, 1> home{"home"};
  CHECK(device->configure(home) == "");
  session.after(10);
  CHECK(fake.counts()[5] == before + 1);
}

TEST_CASE("a device that must be put into its inkwell gets no force before") {
  const Fake fake("inkwell");
  const auto device = make();
  REQUIRE(device->open() == "");
  Session session(*device);
  session.ask({1, 0, 0});
  const haptic::Report report = session.after(300);
  CHECK((report.state.flags & State::kHomed) == 0);
  CHECK(fake.force() == haptic::Vec3{});
  CHECK(device->trouble().find("inkwell") != std::string::npos);
}

TEST_CASE("a scheduler that does not start is refused") {
  const Fake fake("no scheduler");
  const auto device = make();
  REQUIRE(device->open() == "");
  CHECK_FALSE(device->run([](void*) {}, nullptr));
}

TEST_CASE("the library is loaded once, whatever is listed, opened and closed") {
  setenv("FAKE_HD", "", 1);
  setenv("PHANTOM_LIBHD", FAKE_HD, 1);
  const devices::Driver& driver = *devices::find_driver("openhaptics");
  for (int round = 0; round < 3; ++round) {
    CHECK(driver.problem() == "");
    CHECK(driver.list().size() == 1);
    const auto device = make();
    REQUIRE(device->open() == "");
    CHECK(driver.list().at(0).identity.serial == "F-0042");
    CHECK(driver.list().at(0).state == "open in this program");
    device->close();
    CHECK(driver.list().at(0).identity.serial == "");
  }
  CHECK(std::string(getenv("FAKE_HD_LOADS")) == "1");
}

TEST_CASE("a device that is open in this program is refused to another, and goes on") {
  const Fake fake;
  const auto device = make(), other = make();
  REQUIRE(device->open() == "");
  {
    Session session(*device);
    CHECK(other->open().find("open in this program already") != std::string::npos);
    other->close();
    CHECK(fake.counts()[3] == 1); // force is still on
    session.ask({1, 0, 0});
    session.after(200);
    CHECK(fake.force().x == doctest::Approx(1));
  }
  device->close();
  CHECK(other->open() == "");
}

TEST_CASE("an opening that waits between its tries is cancelled") {
  const Fake fake("dead");
  const auto device = make();
  CHECK(cancelled_opening(*device).find("cancelled") != std::string::npos);
}

TEST_CASE("a PHANTOM with six motors is sent torque inside frames, once it was asked for it") {
  const Fake fake("6dof");
  const auto device = make();
  REQUIRE(device->open() == "");
  CHECK(device->caps().peak_torque_n_m == doctest::Approx(0.188));
  double torque[3] = {};
  {
    Session session(*device);
    session.after(300);
    CHECK(fake.torque_of(torque) == 0);
    session.servo.exchange().wrist.write({true, {{0.01, -0.02, 0.3}, 5}});
    session.after(300);
    CHECK(fake.torque_of(torque) > 0);
    const haptic::Vec3 sent = haptic::Vec3{torque[0], torque[1], torque[2]} * 1e-3;
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
  const Fake fake;
  const auto device = make();
  REQUIRE(device->open() == "");
  CHECK(device->caps().peak_torque_n_m == 0);
  Session session(*device);
  session.servo.exchange().wrist.write({true, {{0, 0, 0.1}, 1}});
  session.after(300);
  double torque[3] = {};
  CHECK(fake.torque_of(torque) == 0);
}

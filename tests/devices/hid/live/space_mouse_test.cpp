#include "core/haptic/device/workspace.hpp"
#include "tests/devices/hid/live/rig.hpp"

#include <doctest/doctest.h>

#include <cstdio>
#include <utility>

using tactus::Vec3;

namespace {

bool skipped() { return Rig::is("pad"); }

// A deflection in counts along X, Y, Z, in the reports of the device at hand.
std::string report(int x, int y, int z) {
  std::string text = "report 01";
  for (const int count : {x, y, z}) {
    char hex[5];
    const auto word = static_cast<unsigned>(count) & 0xffffu;
    std::snprintf(hex, sizeof hex, "%02x%02x", word & 255, word >> 8);
    text += hex;
  }
  return Rig::is("compact") ? text + "000000000000" : text;
}

} // namespace

TEST_CASE("a SpaceMouse is listed with its name" * doctest::skip(skipped())) {
  Rig rig;
  std::string problem;
  auto* library = tactus::devices::hid::HidLibrary::get(
      Rig::world("TRANSPORT") == "libusb" ? tactus::devices::hid::Transport::kLibusb
                                          : tactus::devices::hid::Transport::kHidraw,
      problem);
  REQUIRE_MESSAGE(library, problem);
  const auto entries = tactus::devices::hid::catalogue(*library);
  REQUIRE(entries.size() == 1);
  CHECK(entries[0].space_mouse);
  CHECK(entries[0].identity.model ==
        (Rig::is("compact") ? "SpaceMouse Compact" : "SpaceNavigator"));
  CHECK(entries[0].problem.empty());
}

TEST_CASE("full deflection to the right is the workspace's edge" * doctest::skip(skipped())) {
  Rig rig;
  REQUIRE(rig.device.open() == "");
  CHECK(rig.reaches({0, 0, 0}));
  CHECK(rig.moves_to({50, 0, 0}, report(350, 0, 0)));
  const auto caps = rig.device.caps();
  const tactus::haptic::Workspace workspace{caps.workspace_min, caps.workspace_max};
  CHECK(norm(workspace.normalised(rig.state.position) - Vec3{1, 0.5, 0.5}) < 1e-6);
  CHECK(caps.axes_out == 0);
  CHECK(caps.has_rotation);
  CHECK(caps.has_buttons);
  // Half a count of 350 to the edge at 50 mm.
  CHECK(caps.position_noise_m == doctest::Approx(0.5 / 350 * 0.05).scale(0));
  for (const char* unknown : {"report 55 0102", "report 01 02", "report 02"}) { // and goes on
    rig.control.ask(unknown);
    CHECK(rig.moves_to({0, 0, 0}, report(0, 0, 0)));
    CHECK(rig.moves_to({50, 0, 0}, report(350, 0, 0)));
  }
  // towards the user and down: HID's Y and Z
  CHECK(rig.moves_to({0, -50, 50}, report(0, 350, 350)));
  CHECK(rig.moves_to({0, 0, 0}, report(5, -5, 10))); // within the dead zone of 3 %: 10.5 counts
}

TEST_CASE("all six axes come through in both styles of report, also when opened again" *
          doctest::skip(skipped())) {
  Rig rig;
  REQUIRE(rig.set({"deadzone", "0"}) == "");
  const std::vector<std::string> reports =
      Rig::is("compact")
          ? std::vector<std::string>{"report 01 0a00 ecff 1e00 d8ff 3200 c4ff"}
          : std::vector<std::string>{"report 01 0a00 ecff 1e00", "report 02 d8ff 3200 c4ff"};
  for (int opening = 0; opening < 2; ++opening) {
    REQUIRE(rig.device.open() == "");
    CHECK(rig.sent(reports, [&] { // an earlier case's report may still be on its way
      return norm(rig.state.position * 1e3 - Vec3{10, -30, -20} * (50.0 / 350)) < 1e-9 &&
             norm(rig.state.rotation * 350 - Vec3{-40, 60, 50}) < 1e-9;
    }));
  }
}

TEST_CASE("buttons come, the light goes out and on" * doctest::skip(skipped())) {
  Rig rig;
  REQUIRE(rig.device.open() == "");
  const auto last = [&](const char* report) {
    return rig.control.ask("state").find(std::string("last=") + report) != std::string::npos;
  };
  REQUIRE(rig.until([&] { return last("0401"); }));
  rig.control.ask("report 03 0200");
  CHECK(rig.until([&] { return rig.state.buttons == 2; }));
  rig.control.ask("report 03 0000");
  CHECK(rig.until([&] { return rig.state.buttons == 0; }));
  CHECK(rig.set({"led", "0"}) == "");
  CHECK(rig.until([&] { return last("0400"); }));
  CHECK(rig.set({"led", "1"}) == "");
  CHECK(rig.until([&] { return last("0401"); }));
  rig.control.ask("report 17 07");
  CHECK(rig.until([&] { return rig.device.trouble().find("7 %") != std::string::npos; }));
  rig.device.close();
  CHECK(last("0400"));
}

TEST_CASE("a report is reached by a glide, whose speed is that of the hand" *
          doctest::skip(skipped())) {
  Rig rig;
  REQUIRE(rig.device.open() == "");
  int resting = 0; // an earlier case's report may still be on its way
  REQUIRE(rig.sent({report(0, 0, 0)}, [&] {
    resting = norm(rig.state.position) < 1e-9 ? resting + 1 : 0;
    return resting > 100;
  }));
  REQUIRE(rig.sent({report(350, 0, 0)}, [&] { return rig.state.position.x > 0; }));
  // After a pause the usual 10 ms between reports, a quarter longer: 4 mm a tick to 50 mm. When the
  // report came between two ticks does not matter: it counts from the tick that took it.
  double before = rig.state.position.x * 1e3;
  CHECK(before <= doctest::Approx(4));
  int ticks = 1;
  for (; before < 50 - 1e-9 && ticks < 100; ++ticks) {
    rig.step();
    const double now = rig.state.position.x * 1e3;
    CHECK(now - before <= doctest::Approx(4));
    CHECK(now > before);
    before = now;
  }
  CHECK(ticks == 13);
  CHECK(rig.moves_to({0, 0, 0}, report(0, 0, 0)));
}

TEST_CASE("as a rate, deflection moves and the workspace ends it" * doctest::skip(skipped())) {
  Rig rig;
  REQUIRE(rig.set({"mapping", "rate"}) == "");
  REQUIRE(rig.set({"speed", "200"}) == "");
  REQUIRE(rig.device.open() == "");
  REQUIRE(rig.sent({report(-350, 0, 0)}, [&] { return rig.state.position.x < 0; }));
  const double begin = rig.state.position.x;
  for (int i = 0; i < 100; ++i)
    rig.step();
  CHECK(rig.state.position.x - begin == doctest::Approx(-0.2 * 0.1).epsilon(1e-9));
  CHECK(rig.reaches({-50, 0, 0}));
  rig.control.ask(report(0, 0, 0));
  for (int i = 0; i < 50; ++i)
    rig.step();
  CHECK(rig.reaches({-50, 0, 0})); // it stays where it was led
}

TEST_CASE("as a rate, a stall moves by a tenth of a second at most" * doctest::skip(skipped())) {
  Rig rig;
  REQUIRE(rig.set({"mapping", "rate"}) == "");
  REQUIRE(rig.set({"speed", "100"}) == "");
  REQUIRE(rig.device.open() == "");
  REQUIRE(rig.sent({report(-350, 0, 0)}, [&] { return rig.state.position.x < 0; }));
  for (const auto& [passed_s, moved_s] :
       {std::pair{0.07, 0.07}, {0.1, 0.1}, {3.0, 0.1}, {-1.0, 0.0}}) {
    const double before = rig.state.position.x;
    rig.tick.time_s += passed_s;
    CHECK(rig.device.read(rig.tick, rig.state));
    CHECK(rig.state.position.x - before == doctest::Approx(-0.1 * moved_s).epsilon(1e-9));
  }
  rig.control.ask(report(0, 0, 0));
}

TEST_CASE("pulled out it fails, plugged in it opens again" * doctest::skip(skipped())) {
  Rig rig;
  REQUIRE(rig.device.open() == "");
  CHECK(rig.step({1, 2, 3}));
  rig.control.ask("unplug");
  REQUIRE(rig.until([&] { return !rig.device.trouble().empty(); }));
  CHECK_FALSE(rig.step());
  rig.device.close();
  CHECK(rig.device.open().find("plugged in") != std::string::npos);
  rig.control.ask("plug");
  static_cast<void>(rig.set({"device", "no such"}));
  CHECK(rig.device.open().find("no such") != std::string::npos);
  static_cast<void>(rig.set({"device", "0"}));
  REQUIRE(rig.device.open() == "");
  CHECK(rig.moves_to({50, 0, 0}, report(350, 0, 0)));
}

#include "tests/devices/falcon/live/rig.hpp"

#include <cmath>

using namespace tactus::devices::falcon;
using tactus::haptic::State;

TEST_CASE("noise on the line, lost bytes and split packets cost frames and nothing else") {
  Rig rig;
  rig.ready();
  tactus::Vec3 last = rig.state.position;
  double leap = 0;
  for (const char* fault : {"garbage 37", "bad 3", "lose 4", "split 5", "garbage 200"}) {
    CHECK(rig.control.ask(fault) == "ok");
    for (int i = 0; i < 150; ++i) {
      const double before_s = rig.tick.time_s;
      rig.step({0, 1, 0});
      const double stalled_s = rig.tick.time_s - before_s - 0.003; // on a busy machine
      leap = std::max(leap, norm(rig.state.position - last) - 0.3 * std::max(stalled_s, 0.0));
      last = rig.state.position;
    }
  }
  rig.control.ask("split 62");
  rig.run(100);
  CHECK(rig.homed());
  CHECK(leap < 5e-3); // the hand moves at some 0.1 m/s; a wrong packet would leap by centimetres
  CHECK(rig.until([&] { return rig.gap_s == 0; }));
  CHECK(rig.failed_writes == 0);
}

TEST_CASE("a line that is silent for 300 ms fails the reads and then comes back") {
  Rig rig;
  rig.ready();
  rig.run(100);
  rig.control.ask("stall 300");
  CHECK(rig.until([&] { return rig.says("does not answer") && rig.gap_s > 0.02; }));
  REQUIRE(rig.until([&] { return rig.falcon.trouble().empty(); }));
  CHECK(rig.until([&] { return rig.gap_s == 0; }));
}

TEST_CASE("a Falcon stays homed under force: each packet says so") {
  Rig rig;
  rig.ready(true);
  const long frames = rig.control.value("frames");
  bool homed = true;
  REQUIRE(rig.until(
      [&] {
        homed = homed && rig.homed();
        return rig.control.value("frames") > frames + 700;
      },
      30000, {0, 0, 2}));
  CHECK(homed);
  CHECK(std::abs(rig.control.value("motor2")) > 100);
  rig.falcon.close(); // the last one, without force, too
  CHECK(rig.control.value("homed") == 7);
}

TEST_CASE("homed flags that fall take the force away until the grip has been moved again") {
  Rig rig;
  rig.ready();
  rig.run(700, {0, 0, 1});
  rig.control.ask("unhome");
  REQUIRE(rig.until([&] { return !rig.homed(); }, 30000, {0, 0, 1}));
  CHECK(rig.until(
      [&] {
        const std::string state = rig.control.ask("state"); // of one moment
        return state.find("flags=9 motor0=0 ") != std::string::npos;
      },
      30000, {0, 0, 1}));
  CHECK(rig.home());
}

TEST_CASE("encoders that stand still under a newton are a fault, and moving again clears it" *
          doctest::test_suite("slow")) {
  Rig rig;
  rig.ready(true);
  rig.run(700, {1, 0, 0});
  rig.control.ask("freeze 1");
  const auto faulty = [&] { return (rig.state.flags & State::kFault) != 0; };
  CHECK_FALSE(faulty());
  // Every stall of 50 ms begins the watch anew.
  REQUIRE(rig.until(faulty, 300000, {1, 0, 0}));
  CHECK(rig.says("do not change"));
  CHECK(rig.until([&] { return rig.saw("motor0=0") && rig.saw("motor1=0"); }, 30000, {1, 0, 0}));
  SUBCASE("moving again") {
    rig.control.ask("freeze 0");
    CHECK(rig.until([&] { return !faulty(); }));
  }
  SUBCASE("opening again loads the firmware") {
    const long uploads = rig.control.value("uploads");
    rig.falcon.close();
    rig.control.ask("freeze 0");
    REQUIRE(rig.open() == "");
    CHECK(rig.control.value("uploads") == uploads + 1);
    CHECK(rig.home());
  }
}

TEST_CASE("pulled out, the driver fails at once; plugged in, it opens again") {
  Rig rig;
  rig.ready();
  rig.control.ask("unplug");
  REQUIRE(rig.until([&] { return rig.says("was unplugged"); }, 30000, {0, 1, 0}));
  CHECK_FALSE(rig.step());
  CHECK_FALSE(rig.falcon.write({0, 1, 0}));
  rig.falcon.close();
  CHECK(rig.falcon.trouble().empty());
  CHECK_FALSE(rig.step());
  CHECK_FALSE(rig.open().empty());
  rig.control.ask("plug");
  rig.control.ask("forget");
  REQUIRE(rig.open() == "");
  CHECK(rig.home());
}

TEST_CASE("one wild answer is not believed, and changes neither position nor force") {
  Rig rig;
  rig.ready(true);
  REQUIRE(rig.settle());
  const tactus::Vec3 rest = rig.state.position;
  double farthest = 0;
  bool homed = true, flagged = false;
  for (int i = 0; i < 20; ++i) {
    rig.control.ask("wild 1");
    for (int tick = 0; tick < 20; ++tick) {
      rig.step();
      farthest = std::max(farthest, norm(rig.state.position - rest));
      homed = homed && rig.homed();
      flagged = flagged || rig.unreachable();
    }
  }
  CHECK(farthest < 1e-3); // 1000 counts are some 35 mm
  CHECK(homed);
  CHECK_FALSE(flagged);
}

TEST_CASE("angles that the arms cannot have take the force away at that tick") {
  Rig rig;
  rig.ready(true);
  rig.run(700, {0, 0, 2});
  REQUIRE(rig.settle({0, 0, 2}));
  const tactus::Vec3 last = rig.state.position;
  rig.control.ask("pose -2500 2500 -2500");
  REQUIRE(rig.until([&] { return rig.unreachable(); }, 30000, {0, 0, 2}));
  CHECK(norm(rig.state.position - last) < 1e-3);
  // This tick's order already had no force: after it none has been sent that had one.
  CHECK(rig.falls_still());
  const long frames = rig.control.value("frames");
  rig.run(200, {0, 0, 2});
  CHECK(rig.control.value("frames") > frames);
  CHECK(rig.saw("motor2=0"));
  CHECK(rig.unreachable());
  CHECK(rig.until([&] { return rig.says("impossible arm angles"); }, 30000, {0, 0, 2}));
  rig.control.ask("pose");
  REQUIRE(rig.until([&] { return !rig.unreachable(); }));
  CHECK(rig.falcon.trouble().empty());
}

TEST_CASE("a Falcon homes although its angles make no sense before") {
  Rig rig;
  rig.control.ask("pose -2500 2500 -2500");
  rig.control.ask("forget");
  REQUIRE(rig.open() == "");
  rig.step();
  CHECK_FALSE(rig.homed());
  CHECK(rig.says("not homed"));
  REQUIRE(rig.home());
  rig.control.ask("buttons 3");
  CHECK(rig.until([&] { return rig.state.buttons == 3; }));
  rig.control.ask("buttons 0");
  rig.control.ask("pose");
  CHECK(rig.until([&] { return !rig.unreachable(); }));
}

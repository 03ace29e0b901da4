#include "tests/devices/cancelled_opening.hpp"
#include "tests/devices/falcon/live/rig.hpp"

#include <utility>
#include <vector>

using tactus::cancelled_opening;

TEST_CASE("a Falcon on the bus is listed, and one that has left is not") {
  Rig rig;
  const auto* driver = tactus::devices::find_driver("falcon");
  REQUIRE(driver);
  CHECK(driver->problem().empty());
  auto found = driver->list();
  REQUIRE(found.size() == 1);
  CHECK(found[0].driver == "falcon");
  CHECK(found[0].state == "ready");
  CHECK(found[0].identity.model == "Falcon");
  const std::string serial = found[0].identity.serial;
  REQUIRE(rig.open() == "");
  found = driver->list(); // beside the open device, without touching it
  REQUIRE(found.size() == 1);
  CHECK(found[0].index == 0);
  CHECK(found[0].identity.serial == serial);
  CHECK(found[0].state == "open in this program");
  rig.falcon.close();
  REQUIRE(driver->list().size() == 1);
  CHECK(driver->list()[0].state == "ready");
  rig.control.ask("unplug");
  CHECK(driver->list().empty());
  CHECK(rig.falcon.open().find("plugged in") != std::string::npos);
}

TEST_CASE(
    "without firmware the driver says where it comes from, and with a bad file what is wrong") {
  Rig rig;
  rig.control.ask("forget");
  CHECK(rig.falcon.open().find("firmware FILE") != std::string::npos);
  static_cast<void>(rig.set({"firmware", "/nowhere/firmware.bin"}));
  CHECK(rig.falcon.open().find("/nowhere/firmware.bin cannot be read") != std::string::npos);
  CHECK(rig.open(0).find("0 bytes") != std::string::npos);
  CHECK(rig.open(65537).find("has 65537 bytes: expected 1..65536") != std::string::npos);
  rig.set({"device", "no such"});
  CHECK(rig.open().find("Falcon no such: not found") != std::string::npos);
}

TEST_CASE("firmware is uploaded in spite of deaf greetings and two wrong echoes, and not twice") {
  Rig rig;
  rig.control.ask("forget");
  rig.control.ask("deaf 2");
  rig.control.ask("echo 2");
  const long before = rig.control.value("uploads");
  REQUIRE(rig.open() == "");
  CHECK(rig.control.value("uploads") == before + 3);
  CHECK(rig.control.value("firmware") == 500);
  CHECK(rig.control.value("latency") == 1);
  rig.falcon.close();
  REQUIRE(rig.open() == "");
  CHECK(rig.control.value("uploads") == before + 3);
  rig.falcon.close(); // unless it is asked for, of a boot loader that takes its time
  CHECK(rig.set({"reload"}) == "");
  rig.control.ask("boot 400");
  REQUIRE(rig.open(1) == "");
  rig.control.ask("boot 0");
  CHECK(rig.control.value("uploads") == before + 4);
  CHECK(rig.control.value("firmware") == 1);
}

TEST_CASE("nothing is said in run mode to a Falcon that may be in its boot loader") {
  Rig rig;
  rig.control.ask("forget");
  rig.control.ask("shy 1");
  CHECK(rig.open() == "");
  rig.control.ask("shy 0");
  const long uploads = rig.control.value("uploads");
  tactus::devices::falcon::Falcon other; // knows nothing of the firmware that runs
  rig.falcon.close();
  std::vector<std::string> probe{"probe", "1"};
  REQUIRE(other.configure(probe) == "");
  CHECK(other.open() == "");
  CHECK(rig.control.value("uploads") == uploads);
}

TEST_CASE("a Falcon that always echoes wrongly is given up after some tries with advice" *
          doctest::test_suite("slow")) {
  Rig rig;
  rig.control.ask("forget");
  rig.control.ask("echo 1000");
  const std::string problem = rig.open(200);
  rig.control.ask("echo 0");
  CHECK(problem.find("returned wrong firmware data near byte 62") != std::string::npos);
  CHECK(problem.find("another port") != std::string::npos);
  CHECK(rig.open() == "");
}

TEST_CASE("the opening of a deaf Falcon is cancelled in a third of a second, wherever it is") {
  Rig rig;
  rig.control.ask("deaf 100000");
  for (const int wait_ms : {20, 700}) {
    rig.control.ask("forget");
    const auto begun = std::chrono::steady_clock::now();
    CHECK(cancelled_opening(
              rig.falcon, [&] { return rig.open(); }, wait_ms)
              .find("cancelled") != std::string::npos);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
    CHECK(took.count() < 20); // 0.3 s, and what a busy machine adds; uncancelled, 100 s
  }
  rig.control.ask("deaf 0");
  CHECK(rig.open() == "");
}

TEST_CASE("no force before homing, full force half a second after") {
  Rig rig;
  rig.control.ask("still");
  REQUIRE(rig.open() == "");
  rig.control.ask("unhome");
  REQUIRE(rig.until([&] { return !rig.homed(); }));
  bool silent = true;
  REQUIRE(rig.until(
      [&] {
        silent = silent && (rig.homed() || rig.control.value("motor2") == 0);
        return rig.homed();
      },
      30000, {0, 0, 2}));
  CHECK(silent);
  // What the motors have at any instant is no more than the rise allows by then.
  const double homed_s = rig.tick.time_s;
  std::vector<std::pair<double, long>> rise;
  // Until the force has been the same for 100 ticks: a stall lets it rise anew.
  CHECK(rig.until(
      [&, held = 0]() mutable {
        const long motor = std::abs(rig.control.value("motor2"));
        held =
            motor > 100 && !rise.empty() && std::abs(motor - rise.back().second) < 3 ? held + 1 : 0;
        rise.emplace_back(rig.now_s() - homed_s, motor);
        return rig.tick.time_s - homed_s > 0.8 && held > 100;
      },
      30000, {0, 0, 2}));
  const auto full = static_cast<double>(rise.back().second);
  CHECK(full > 100);
  for (const auto& [time_s, motor] : rise)
    CHECK(static_cast<double>(motor) <= (0.05 + 1.2 * time_s / 0.5) * full);
  CHECK(rig.until([&] { return rig.saw("flags=3"); }, 30000, {0, 0, 2})); // green, kept homed
  CHECK(rig.until([&] { return rig.falcon.trouble().empty(); }));
}

#include "tests/devices/hid/live/rig.hpp"

#include <doctest/doctest.h>

#include <cstdio>
#include <fstream>

#include <unistd.h>

namespace {
bool skipped() { return !Rig::is("pad"); }
} // namespace

TEST_CASE("any HID with axes works by its own description" * doctest::skip(skipped())) {
  Rig rig;
  const auto* driver = tactus::devices::find_driver("hid");
  REQUIRE(driver);
  const auto found = driver->list();
  REQUIRE(found.size() == 1);
  CHECK(found[0].identity.serial == "PAD7");
  REQUIRE(rig.set({"device", "PAD7"}) == "");
  REQUIRE(rig.set({"deadzone", "0"}) == "");
  REQUIRE(rig.device.open() == "");
  CHECK(rig.device.identity().model == "Pad");
  // Half a count of 255 from edge to edge, 100 mm.
  CHECK(rig.device.caps().position_noise_m == doctest::Approx(0.5 * 0.1 / 255).scale(0));
  // X right, Y towards, Rx, Ry, slider up; buttons 1 and 10
  rig.control.ask("report ff 00 80 80 ff 0102");
  CHECK(rig.reaches({50, 50, -50}));
  CHECK(rig.state.buttons == 0x201);
  CHECK(rig.state.rotation.x == doctest::Approx(1.0 / 255));
}

TEST_CASE("an axis table changes what drives what" * doctest::skip(skipped())) {
  Rig rig;
  const std::string file = "axis_table_" + std::to_string(getpid()) + ".txt";
  std::ofstream(file) << "x Rx\ny -Ry\nz none\n";
  REQUIRE(rig.set({"table", "/nowhere/table"}) == "");
  CHECK(rig.device.open().find("/nowhere/table") != std::string::npos);
  REQUIRE(rig.set({"table", file}) == "");
  REQUIRE(rig.device.open() == "");
  rig.control.ask("report 00 00 ff ff 80 0000");
  CHECK(rig.reaches({50, -50, 0}));
  std::remove(file.c_str());
}

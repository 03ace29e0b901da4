#include "devices/hid/axis_table.hpp"
#include "devices/hid/catalogue.hpp"

#include <doctest/doctest.h>

using namespace tactus::devices::hid;

TEST_CASE("the usual table turns right, towards, down into right, up, towards") {
  Knob knob;
  knob.share = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
  const AxisTable table = AxisTable::default_for(0x3f);
  CHECK(table.position(knob) == tactus::Vec3{0.1, -0.3, 0.2});
  CHECK(table.rotation(knob) == tactus::Vec3{0.4, -0.6, 0.5});
  // Right, up, away: an early SpaceMouse (spacenavd, src/dev.c).
  CHECK(AxisTable::default_for(0x3f, true).position(knob) == tactus::Vec3{0.1, 0.2, -0.3});
  CHECK(AxisTable::default_for(0x3f, true).rotation(knob) == tactus::Vec3{0.4, 0.5, -0.6});
  for (const int id : {0xc603, 0xc606, 0xc640, 0xc605, 0xc621, 0xc626, 0xc641})
    CHECK(is_early_space_mouse(0x046d, static_cast<std::uint16_t>(id)) ==
          (id == 0xc603 || id == 0xc606 || id == 0xc640));
  CHECK_FALSE(is_early_space_mouse(0x256f, 0xc603));
  CHECK(AxisTable::default_for(0x43).position(knob) == tactus::Vec3{0.1, 0.7, 0.2});
}

TEST_CASE("a table of the user's replaces the rows that it names") {
  Knob knob;
  knob.share = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
  AxisTable table = AxisTable::default_for(0x3f);
  CHECK(table.read("# stick\n\n x -Rz  # twisted\ny none\nrz Wheel\n") == "");
  CHECK(table.position(knob) == tactus::Vec3{-0.6, 0, 0.2});
  CHECK(table.rotation(knob) == tactus::Vec3{0.4, -0.6, 0.9});
}

TEST_CASE("a mistake in a table is named by its line and changes nothing") {
  Knob knob;
  knob.share[0] = 1;
  for (const char* text : {"x", "x Q", "w X", "x X X", "x -", "x -none"}) {
    AxisTable table = AxisTable::default_for(0x3f);
    const std::string mistake = table.read(std::string("y X\n") + text + "\n");
    CHECK(mistake.find("line 2") != std::string::npos);
    CHECK(table.position(knob) == tactus::Vec3{1, 0, 0});
  }
}

TEST_CASE("the dead zone is silent and full deflection stays full") {
  CHECK(apply_dead_zone(0.03, 0.03) == 0);
  CHECK(apply_dead_zone(-0.02, 0.03) == 0);
  CHECK(apply_dead_zone(1, 0.03) == 1);
  CHECK(apply_dead_zone(-1, 0.03) == -1);
  CHECK(apply_dead_zone(0.515, 0.03) == doctest::Approx(0.5));
  CHECK(apply_dead_zone(0.5, 0) == 0.5);
}

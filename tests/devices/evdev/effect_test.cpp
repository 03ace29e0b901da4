#include "devices/evdev/effect.hpp"
#include "devices/evdev/joysticks.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

using namespace tactus::devices::evdev;

TEST_CASE("the four directions of the kernel's documentation") {
  CHECK(constant_force({0, 0, 1}, 2, true) == ConstantForce{16384, 0x0000});  // down: to the user
  CHECK(constant_force({-1, 0, 0}, 2, true) == ConstantForce{16384, 0x4000}); // left
  CHECK(constant_force({0, 0, -1}, 2, true) == ConstantForce{16384, 0x8000}); // up: away
  CHECK(constant_force({1, 0, 0}, 2, true) == ConstantForce{16384, 0xC000});  // right
}

TEST_CASE("level and direction give the force back") {
  for (int i = 0; i < 360; ++i) {
    const double angle = i * std::numbers::pi / 180, length = 0.01 + i * 0.005;
    const double x = length * std::cos(angle), z = length * std::sin(angle);
    const ConstantForce force = constant_force({x, 5, z}, 2, true);
    const double turn = force.direction * 2 * std::numbers::pi / 65536;
    const double back = force.level * 2.0 / 32767;
    // Half a step of the level, and half a step of the direction at this length.
    const double tolerance = 0.5 * 2 / 32767 + length * std::numbers::pi / 65536 + 1e-12;
    CHECK(std::abs(-back * std::sin(turn) - x) <= tolerance);
    CHECK(std::abs(back * std::cos(turn) - z) <= tolerance);
  }
}

TEST_CASE("too much is full force, a wheel has x alone, and no number is no force") {
  CHECK(constant_force({30, 0, 0}, 2, true).level == 32767);
  CHECK(constant_force({0, 0, 1}, 2, false) == ConstantForce{0, 0x4000});
  CHECK(constant_force({1, 0, 9}, 2, false) == ConstantForce{-16384, 0x4000});
  CHECK(constant_force({-9, 0, 9}, 2, false) == ConstantForce{32767, 0x4000});
  CHECK(constant_force({NAN, 0, 0}, 2, false) == ConstantForce{0, 0x4000});
  const double inf = std::numeric_limits<double>::infinity();
  CHECK(constant_force({NAN, 0, 0}, 2, true) == ConstantForce{});
  CHECK(constant_force({0, 0, inf}, 2, true) == ConstantForce{});
  CHECK(constant_force({1, 0, 0}, 0, true) == ConstantForce{});
}

TEST_CASE("bitmaps of /sys are read from their end") {
  CHECK(bit("100040000 0", 0x52));
  CHECK_FALSE(bit("100040000 0", 0x51));
  CHECK_FALSE(bit("0", 0x52));
  CHECK_FALSE(bit("", 0));
  CHECK(bit("7", 2));
  CHECK_FALSE(bit("7", 3));
}

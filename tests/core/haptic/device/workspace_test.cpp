#include "core/haptic/device/workspace.hpp"

#include <doctest/doctest.h>

#include <limits>

using namespace tactus::haptic;
using tactus::Vec3;

TEST_CASE("positions are normalised over the workspace, clamped, and 0.5 on a flat axis") {
  const Workspace touch{{-0.08, -0.06, -0.035}, {0.08, 0.06, 0.035}};
  CHECK(touch.normalised({0, 0, 0}) == Vec3{0.5, 0.5, 0.5});
  CHECK(norm(touch.normalised({0.04, -0.075, 0.01}) - Vec3{0.75, 0, 0.045 / 0.07}) < 1e-12);
  const Workspace flat{{-1, 2, 0}, {1, 2, 1}};
  CHECK(flat.normalised({5, 2, -5}) == Vec3{1, 0.5, 0});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(flat.normalised({nan, nan, 0.25}) == Vec3{0.5, 0.5, 0.25});
}

TEST_CASE("a workspace grows to hold what it has seen") {
  Workspace box{{1, 1, 1}, {1, 1, 1}};
  box.include({0, 2, 1});
  box.include({std::numeric_limits<double>::infinity(), 0, 0});
  CHECK(box == Workspace{{0, 1, 1}, {1, 2, 1}});
  CHECK(box.valid());
  CHECK_FALSE(Workspace{{1, 0, 0}, {0, 1, 1}}.valid());
}

TEST_CASE("an axis map keeps power and comes back; what is no permutation with signs is refused") {
  const auto map = AxisMap::parse("zxy", {1, -1, 1});
  REQUIRE(map);
  CHECK(map->to_project({1, 2, 3}) == Vec3{3, -1, 2});
  const Vec3 velocity{0.3, -0.2, 0.7}, force{1, 2, -3};
  CHECK(dot(map->to_project(velocity), force) ==
        doctest::Approx(dot(velocity, map->to_device(force))).epsilon(1e-15));
  CHECK(map->to_device(map->to_project(velocity)) == velocity);
  for (const char* axes : {"xxy", "xy", "xyw"})
    CHECK_FALSE(AxisMap::parse(axes, {1, 1, 1}));
  CHECK_FALSE(AxisMap::parse("xyz", {1, 0, 1}));
  CHECK_FALSE(AxisMap::parse("xyz", {1, 1, 0.5}));
}

#include "tests/core/haptic/scene/scene_rig.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <numbers>

// What counts as a hit, in which order, and how a hand that starts inside is led out.

using namespace tactus::haptic;
using test::SceneRig;
using Kind = ContactEvent::Kind;

namespace {

/// Hits in 2 s of a handle that swings about the surface of a plane. mm, Hz
std::size_t hits_of_swing(double amplitude_mm, double frequency_hz) {
  SceneRig rig;
  rig.add(Plane{});
  for (int n = 0; n < 2000; ++n) // begins outside, on its way in
    rig.touch(
        {0, 0, amplitude_mm * std::cos(2 * std::numbers::pi * frequency_hz * (n + 0.5) * 1e-3)});
  return rig.count(Kind::kHit);
}

} // namespace

TEST_CASE("chatter at 40 Hz is a hit for each departure of 0.2 mm and 10 ms, and else one") {
  // Half of a period of 25 ms is spent in the air: long enough, so that the distance decides.
  CHECK(hits_of_swing(0.05, 40) == 1);
  CHECK(hits_of_swing(0.15, 40) == 1);
  CHECK(hits_of_swing(0.3, 40) == 80);
  CHECK(hits_of_swing(1, 40) == 80);
  // Half of 10 ms is too short, however far it goes.
  CHECK(hits_of_swing(1, 100) == 1);
  CHECK(hits_of_swing(5, 100) == 1);
}

TEST_CASE("a drum roll gives all its hits") {
  CHECK(hits_of_swing(5, 20) == 40);
  CHECK(hits_of_swing(5, 10) == 20);
}

TEST_CASE("leaving along the surface, over an edge, counts like leaving away from it") {
  SceneRig rig;
  rig.add(Box{{0.02, 0.01, 0.02}});
  rig.stroke({15, 12, 0}, {15, 9, 0});
  // Past the edge at the depth of 1 mm: never above the face. Then round it and down again.
  rig.stroke({15, 9, 0}, {25, 9, 0});
  rig.stroke({25, 9, 0}, {25, 12, 0}, 1);
  rig.stroke({25, 12, 0}, {15, 12, 0}, 1);
  rig.stroke({15, 12, 0}, {15, 9, 0});
  CHECK(rig.count(Kind::kHit) == 2);
}

TEST_CASE("bodies reached at one tick are reported in the scene's order") {
  for (const bool swapped : {false, true}) {
    SceneRig rig;
    const Pose floor{{}, Rotation::from_z_to({0, 1, 0})}, wall{{}, Rotation::from_z_to({1, 0, 0})};
    rig.add(Plane{}, swapped ? wall : floor);
    rig.add(Plane{}, swapped ? floor : wall);
    rig.touch({3, 3, 0});
    rig.touch({1, 1, 0});
    rig.touch({-1, -1.5, 0});
    std::vector<std::uint64_t> hits;
    for (const ContactEvent& event : rig.events)
      if (event.kind == Kind::kHit)
        hits.push_back(event.key);
    CHECK(hits == std::vector<std::uint64_t>{1, 2});
  }
}

TEST_CASE("of two bodies with the same face the first one is touched") {
  for (const double first : {300.0, 900.0}) {
    SceneRig rig;
    rig.add(Plane{}, {}, {first, 0, 0});
    rig.add(Plane{}, {}, {1200 - first, 0, 0});
    CHECK(norm(rig.stroke({0, 0, 5}, {0, 0, -2}) - Vec3{0, 0, first * 2e-3}) < 1e-9);
  }
}

TEST_CASE("a body that appears around a fast hand is no hit") {
  SceneRig rig;
  for (int n = 0; n < 20; ++n) // 0.25 m/s into where the sphere will be
    rig.touch({25 - 0.25 * n, 0, 0});
  rig.add(Sphere{0.025});
  for (int n = 20; n < 40; ++n)
    rig.touch({25 - 0.25 * n, 0, 0});
  CHECK(rig.count(Kind::kContact) > 0);
  CHECK(rig.count(Kind::kHit) == 0);
}

TEST_CASE("a hand that starts inside is pushed out with at most the device's continuous force") {
  struct Case {
    double continuous_n, limit_n;
  };
  for (const Case& c : {Case{0, 1}, Case{0.88, 0.88}, Case{40, 1}, Case{-3, 1},
                        Case{std::numeric_limits<double>::quiet_NaN(), 1}}) {
    SceneRig rig;
    rig.model.set_continuous_force(c.continuous_n);
    rig.add(Sphere{0.03}, {}, {2000, 5, 0.8}); // 17 mm deep: 34 N
    double largest = 0;
    for (int n = 0; n < 1000; ++n) // it drags along the surface and goes deeper as well
      largest = std::max(largest, norm(rig.touch({13 - 0.005 * n, 0.01 * n, 0})));
    CHECK(largest == doctest::Approx(c.limit_n).epsilon(1e-9));
  }
}

TEST_CASE("several bodies around the hand share that limit, and have full force after the exit") {
  SceneRig rig;
  rig.add(Plane{}, {{0.002, 0, 0}, Rotation::from_z_to({1, 0, 0})});
  rig.add(Plane{}, {{0, 0.003, 0}, Rotation::from_z_to({0, 1, 0})});
  rig.add(Plane{}, {{0, 0, 0.01}, {}});
  double largest = 0;
  for (int n = 0; n < 1000; ++n)
    largest = std::max(largest, norm(rig.touch({0, 0, 0})));
  CHECK(largest == doctest::Approx(1).epsilon(1e-9));
  CHECK(rig.model.touches().size() == 3);
  rig.stroke({0, 0, 0}, {10, 10, 20});
  CHECK(norm(rig.stroke({10, 10, 20}, {10, 10, 2}) - Vec3{0, 0, 4}) < 1e-9);
}

TEST_CASE("where the exit of one body lies in another, that one pushes the tool on") {
  SceneRig rig;
  rig.add(Sphere{0.01}, {{0, 0, 0}, {}});
  rig.add(Sphere{0.01}, {{0.012, 0, 0}, {}}); // the nearest exit of the first lies in it
  for (int n = 0; n < 1000; ++n)
    rig.touch({5, 1, 0});
  for (const Body& body : rig.scene.bodies)
    CHECK(norm(rig.model.proxy() - body.pose.position) > 0.01);
}

TEST_CASE("a wall's damper acts on the approach only and never pulls") {
  const double k = 500, b = 5;
  SceneRig rig;
  rig.add(Plane{}, {}, {k, b, 0});
  rig.stroke({0, 0, 1}, {0, 0, -2});
  for (int n = 0; n < 8; ++n) { // 0.2 m/s out: the spring alone, never less
    const double z = -2 + 0.2 * (n + 1);
    CHECK(norm(rig.touch({0, 0, z}) - Vec3{0, 0, -k * z * 1e-3}) < 1e-9);
  }
  SceneRig in;
  in.add(Plane{}, {}, {k, b, 0});
  in.touch({0, 0, 0.2});
  CHECK(norm(in.touch({0, 0, -0.2}) - Vec3{0, 0, k * 0.2e-3 + b * 0.4}) < 1e-9);
}

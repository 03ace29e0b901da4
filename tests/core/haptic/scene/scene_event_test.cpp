#include "tests/core/haptic/scene/scene_rig.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <numbers>

// What counts as a hit, in which order, and how a hand that starts inside is led out.

using namespace tactus::haptic;
using tactus::Vec3;
using test::SceneRig;

TEST_CASE("chatter at 40 Hz is a hit for each departure of 0.2 mm and 10 ms, and else one") {
  const struct {
    double amplitude_mm, frequency_hz;
    std::size_t hits; ///< in 2 s of a handle that swings about the surface of a plane
  } cases[] = {
      // Half of a period of 25 ms is spent in the air: long enough, so that the distance decides.
      {0.05, 40, 1},
      {0.15, 40, 1},
      {0.3, 40, 80},
      {1, 40, 80},
      // Half of 10 ms is too short, however far it goes.
      {1, 100, 1},
      {5, 100, 1},
      // A drum roll gives all its hits.
      {5, 20, 40},
      {5, 10, 20},
  };
  for (const auto& c : cases) {
    CAPTURE(c.amplitude_mm);
    CAPTURE(c.frequency_hz);
    SceneRig rig;
    rig.add(Plane{});
    for (int n = 0; n < 2000; ++n) // begins outside, on its way in
      rig.touch(
          {0, 0,
           c.amplitude_mm * std::cos(2 * std::numbers::pi * c.frequency_hz * (n + 0.5) * 1e-3)});
    CHECK(rig.count<HitEvent>() == c.hits);
  }
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
  CHECK(rig.count<HitEvent>() == 2);
}

TEST_CASE("bodies reached at one tick are reported in the scene's order, and of two with the same "
          "face the first one is touched") {
  for (const bool swapped : {false, true}) {
    SceneRig rig;
    const Pose floor{{}, Rotation::from_z_to({0, 1, 0})}, wall{{}, Rotation::from_z_to({1, 0, 0})};
    rig.add(Plane{}, swapped ? wall : floor);
    rig.add(Plane{}, swapped ? floor : wall);
    rig.touch({3, 3, 0});
    rig.touch({1, 1, 0});
    rig.touch({-1, -1.5, 0});
    std::vector<std::uint64_t> hits;
    for (const SceneEvent& event : rig.events)
      if (const auto* const hit = std::get_if<HitEvent>(&event))
        hits.push_back(hit->key);
    CHECK(hits == std::vector<std::uint64_t>{1, 2});
    SceneRig twice;
    const double first = swapped ? 900 : 300;
    twice.add(Plane{}, {}, {first, 0, 0});
    twice.add(Plane{}, {}, {1200 - first, 0, 0});
    CHECK(norm(twice.stroke({0, 0, 5}, {0, 0, -2}) - Vec3{0, 0, first * 2e-3}) < 1e-9);
  }
}

TEST_CASE("a body that appears around a fast hand is no hit") {
  SceneRig rig;
  for (int n = 0; n < 40; ++n) { // 0.25 m/s into where the sphere will be
    if (n == 20)
      rig.add(Sphere{0.025});
    rig.touch({25 - 0.25 * n, 0, 0});
  }
  CHECK(rig.count<ContactEvent>() > 0);
  CHECK(rig.count<HitEvent>() == 0);
}

TEST_CASE("a body that appears around the hand pushes it out with a slowly rising force") {
  SceneRig rig;
  rig.touch({18, 0, 0});
  rig.add(Sphere{0.02});
  CHECK(norm(rig.touch({18, 0, 0})) < 0.01);
  CHECK(rig.rest(4, {18, 0, 0}).x == doctest::Approx(0.4).epsilon(1e-9)); // 100 N/s
  CHECK(norm(rig.rest(20, {18, 0, 0}) - Vec3{1, 0, 0}) < 1e-9);
  CHECK(rig.count<HitEvent>() == 0);
}

TEST_CASE("a hand that starts inside is pushed out with at most the device's continuous force") {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [continuous_n, limit_n] :
       {std::pair{0.0, 1.0}, {0.88, 0.88}, {40.0, 1.0}, {-3.0, 1.0}, {kNone, 1.0}}) {
    SceneRig rig;
    rig.model.set_continuous_force(continuous_n);
    rig.add(Sphere{0.03}, {}, {2000, 5, 0.8}); // 17 mm deep: 34 N
    double largest = 0;
    for (int n = 0; n < 1000; ++n) // it drags along the surface and goes deeper as well
      largest = std::max(largest, norm(rig.touch({13 - 0.005 * n, 0.01 * n, 0})));
    CHECK(largest == doctest::Approx(limit_n).epsilon(1e-9));
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
  rig.rest(1000, {5, 1, 0});
  for (const Body& body : rig.scene.bodies)
    CHECK(norm(rig.model.proxy() - body.pose.position) > 0.01);
}

#include "core/haptic/scene/half_spaces.hpp"
#include "tests/core/haptic/scene/scene_rig.hpp"

#include <doctest/doctest.h>

// Bodies that move, appear and go; the parts that the scene is made of.

using namespace tactus::haptic;
using tactus::Vec3;
using test::SceneRig;

namespace {

double error(const Vec3& is, const Vec3& should) { return norm(is - should); }

} // namespace

TEST_CASE("of any number of bodies that move at once each pushes the hand in its way, and its "
          "damper feels its speed") {
  for (int count = 1; count <= 7; ++count)
    for (int hand = 0; hand < count; ++hand) {
      CAPTURE(count);
      CAPTURE(hand);
      const Vec3 at{0, 40. * hand, 0};
      SceneRig rig;
      for (int i = 0; i < count; ++i)
        rig.add(Sphere{0.01}, {{-0.05, 0.04 * i, 0}, {}}, {500, 2, 0});
      CHECK(rig.rest(10, at) == Vec3{});
      const auto all_to = [&](double x_m) {
        for (std::size_t i = 0; i < rig.scene.bodies.size(); ++i)
          rig.glide(i, {x_m, rig.scene.bodies[i].pose.position.y, 0}, 0.09);
      };
      all_to(-0.005); // 5 mm deep at 0.5 m/s, and then at rest
      CHECK(error(rig.rest(90, at), {500 * 5e-3 + 2 * 0.5, 0, 0}) < 1e-6);
      CHECK(error(rig.touch(at), {2.5, 0, 0}) < 1e-9);
      REQUIRE(rig.count<HitEvent>() == 1);
      CHECK(std::get<HitEvent>(rig.events[0]).approach_m_per_s ==
            doctest::Approx(0.5).epsilon(1e-6));
      all_to(-0.05);
      CHECK(rig.rest(100, at) == Vec3{});
      CHECK(rig.count<ReleaseEvent>() == 1);
    }
}

TEST_CASE("a rough moving floor takes the proxy along until it slips") {
  SceneRig rig;
  rig.add(Plane{}, {}, {500, 0, 0.5});
  rig.stroke({0, 0, 3}, {0, 0, -2});
  rig.glide(0, {0.004, 0, 0}, 0.4); // 10 mm/s
  for (int n = 1; n <= 400; ++n)
    CHECK(error(rig.touch({0, 0, -2}), {500 * std::min(0.01e-3 * n, 1e-3), 0, 1}) <
          1e-9); // mu 2 mm = 1 mm
}

TEST_CASE("a rotating box takes the proxy on it along") {
  SceneRig rig;
  rig.add(Box{{0.05, 0.01, 0.05}}, {}, {500, 0, 10});
  rig.stroke({30, 20, 0}, {30, 8, 0});
  rig.scene.bodies[0].pose.rotation = Rotation::of(std::cos(0.1), 0, std::sin(0.1), 0);
  rig.glide(0, {}, 0.2);
  const Vec3 force = rig.rest(200, {30, 8, 0});
  // 0.2 rad about y: the proxy went along a circle of 30 mm.
  const Vec3 went{30 * std::cos(0.2), 10, -30 * std::sin(0.2)};
  CHECK(error(rig.proxy_mm(), went) < 1e-6);
  CHECK(error(force, (went - Vec3{30, 8, 0}) * 0.5) < 1e-6);
}

TEST_CASE("a body that pushes the hand does not push it through another") {
  SceneRig rig;
  rig.add(Box{{1e-3, 0.03, 0.03}}); // a plate at x = 0
  rig.add(Sphere{0.01}, {{-0.03, 0, 0}, {}});
  rig.rest(2, {-10, 0, 0});
  rig.glide(1, {0.03, 0, 0}, 0.06);
  for (int n = 0; n < 80; ++n) {
    rig.touch({-10, 0, 0});
    REQUIRE(rig.model.proxy().x < -1e-3);
  }
}

TEST_CASE("edits keep the contact of the bodies that they do not touch") {
  SceneRig rig;
  rig.add(Disk{0.05, 0.006});
  rig.stroke({0, 0, 20}, {0, 0, -8}); // past the lower face, held by the upper one
  for (int edit = 0; rig.scene.bodies.size() <= 60; ++edit) {
    if (edit % 3 == 2) {
      rig.scene.bodies.erase(rig.scene.bodies.begin());
    } else {
      Body body = rig.scene.bodies.back();
      body.key = 1000 + static_cast<std::uint64_t>(edit);
      body.pose.position.x = 1;
      rig.scene.bodies.insert(rig.scene.bodies.begin(), body);
    }
    rig.publish();
    CHECK(error(rig.touch({0, 0, -8}), {0, 0, 7}) < 1e-9);
  }
  CHECK(rig.count<HitEvent>() == 1);
  CHECK(rig.count<ReleaseEvent>() == 0);
  rig.scene.bodies.clear();
  rig.publish();
  CHECK(rig.touch({0, 0, -8}) == Vec3{});
  CHECK(rig.count<ReleaseEvent>() == 1);
}

TEST_CASE("a hundred edits between two ticks are one, and none is lost when nobody collects") {
  SceneRig rig;
  for (int i = 0; i < 100; ++i)
    rig.add(Sphere{0.001}, {{1.0 + i, 0, 0}, {}});
  rig.add(Plane{});
  // 101 bodies were asked for: the first 72 are felt.
  CHECK(rig.stroke({0, 0, 5}, {0, 0, -2}) == Vec3{});
  rig.scene.bodies.erase(rig.scene.bodies.begin(), rig.scene.bodies.begin() + 100);
  rig.publish();
  CHECK(error(rig.stroke({0, 0, 5}, {0, 0, -2}), {0, 0, 1}) < 1e-9);
}

TEST_CASE("the nearest point of half spaces is the one that alternating projections find") {
  // Dykstra's algorithm: independent of active sets, slow and sure.
  tactus::Random random(5);
  int compared = 0;
  for (int round = 0; round < 120; ++round) {
    std::array<HalfSpace, kMaxHalfSpaces> faces{};
    const std::size_t count = 1 + static_cast<std::size_t>(random.uniform() * 4);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 n = test::random_point(random, 1);
      // The origin is allowed: there is a solution.
      faces[i] = {n * (1 / norm(n)), -0.01 * random.uniform()};
    }
    const Vec3 goal = test::random_point(random, 0.5);
    const auto nearest = nearest_point({faces.data(), count}, goal);
    REQUIRE(nearest);
    Vec3 x = goal, rebuilt = goal;
    std::array<Vec3, kMaxHalfSpaces> correction{};
    for (int pass = 0; pass < 20000; ++pass)
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3 y = x + correction[i];
        const double violation = faces[i].offset - dot(faces[i].normal, y);
        x = violation > 0 ? y + faces[i].normal * violation : y;
        correction[i] = y - x;
      }
    for (std::size_t i = 0; i < count; ++i)
      rebuilt += faces[i].normal * nearest->multiplier[i];
    CHECK(error(rebuilt, nearest->point) < 1e-9);
    if (error(x, nearest->point) < 1e-3) { // sharp wedges converge too slowly to compare closely
      CHECK(norm(nearest->point - goal) <= norm(x - goal) + 1e-6);
      ++compared;
    }
  }
  CHECK(compared > 110);
}

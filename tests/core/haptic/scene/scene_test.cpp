#include "tests/approx.hpp"
#include "tests/core/haptic/scene/scene_rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::haptic;
using tactus::Vec3;
using test::SceneRig;

namespace {

void check(const Vec3& is, const Vec3& should) {
  INFO("is " << is.x << " " << is.y << " " << is.z << ", should be " << should.x << " " << should.y
             << " " << should.z);
  CHECK(norm(is - should) <= 1e-9 * std::max(norm(should), 1.0));
}

} // namespace

TEST_CASE("a sphere pushes along its radius with k times the depth") {
  SceneRig rig, diagonal;
  rig.add(Sphere{0.02});
  check(rig.stroke({30, 0, 0}, {18, 0, 0}), {1, 0, 0});
  check(rig.stroke({30, 0, 0}, {18, 0, 0}), {1, 0, 0});
  diagonal.add(Sphere{0.02});
  // 500 N/m (20 mm - 12 sqrt 2 mm) along the diagonal.
  const double share = 500 * (0.02 - 0.012 * std::sqrt(2.0)) / std::sqrt(2.0);
  CHECK(share == doctest::Approx(1.071068).epsilon(1e-6));
  check(diagonal.stroke({20, 20, 0}, {12, 12, 0}), {share, share, 0});
}

TEST_CASE("a box entered through its top is felt from its top") {
  SceneRig rig;
  rig.add(Box{{0.03, 0.01, 0.02}});
  check(rig.stroke({0, 15, 0}, {0, 7, 0}), {0, 1.5, 0});
  // Nearer to the side than to the top now, and then below the bottom: still the top.
  check(rig.stroke({0, 7, 0}, {29, 7, 0}), {0, 1.5, 0});
  check(rig.stroke({29, 7, 0}, {29, -12, 0}), {0, 11, 0});
}

TEST_CASE("the proxy never passes through a thin disk") {
  SceneRig rig, leap;
  rig.add(Disk{0.05, 0.006});
  check(rig.stroke({0, 0, 20}, {0, 0, -3}), {0, 0, 4.5});
  check(rig.proxy_mm(), {0, 0, 6});
  check(rig.stroke({0, 0, -3}, {10, -20, -40}), {0, 0, 23});
  check(rig.proxy_mm(), {10, -20, 6});
  // Past the rim there is nothing left to hold the proxy up.
  check(rig.stroke({10, -20, -40}, {60, -20, -40}), {0, 0, 0});
  // From below it is the lower face that is met.
  check(rig.stroke({60, -20, -40}, {10, -20, -40}), {0, 0, 0});
  check(rig.stroke({10, -20, -40}, {10, -20, -4}), {0, 0, -1});
  // In one tick from one side to the other is a contact too.
  leap.add(Disk{0.05, 0.006});
  leap.touch({3, 4, 30});
  check(leap.touch({3, 4, -30}), {0, 0, 18});
}

TEST_CASE("a plane pushes along its normal, wherever it lies") {
  SceneRig rig;
  const Vec3 normal = Vec3{1, 2, 2} * (1.0 / 3.0);
  rig.add(Plane{}, {normal * 0.01, Rotation::from_z_to({2, 4, 4})});
  check(rig.stroke(normal * 30, normal * 7), normal * 1.5);
  check(rig.stroke(normal * 7, normal * 7 + Vec3{10, -5, 0}), normal * 1.5);
  check(rig.stroke(normal * 7, normal * 12), {0, 0, 0});
}

TEST_CASE("a wall's damper acts on the approach only and never pulls") {
  const double k = 500, b = 5;
  SceneRig rig, in;
  rig.add(Plane{}, {}, {k, b, 0});
  rig.stroke({0, 0, 1}, {0, 0, -2});
  for (int n = 1; n <= 8; ++n) { // 0.2 m/s out: the spring alone, never less
    const double z = -2 + 0.2 * n;
    check(rig.touch({0, 0, z}), {0, 0, -k * z * 1e-3});
  }
  in.add(Plane{}, {}, {k, b, 0});
  in.touch({0, 0, 0.2});
  check(in.touch({0, 0, -0.2}), {0, 0, k * 0.2e-3 + b * 0.4});
}

TEST_CASE("a strike is one hit, at the tick in which the surface is passed") {
  SceneRig rig;
  const auto key = rig.add(Disk{0.05, 0.006}).key;
  for (int n = 0; n <= 80; ++n)
    rig.touch({25, 0, 20.1 - 0.25 * n});
  rig.rest(200, {25, 0, 0.1});
  REQUIRE(rig.count<HitEvent>() == 1);
  const auto& hit = std::get<HitEvent>(rig.events.front());
  CHECK(hit.key == key);
  CHECK(hit.time_s == doctest::Approx(57e-3).epsilon(1e-12));
  check(hit.point * 1e3, {25, 0, 6});
  check(hit.normal, {0, 0, 1});
  CHECK(hit.approach_m_per_s == doctest::Approx(0.25).epsilon(1e-9));
  CHECK(hit.slip_m_per_s == doctest::Approx(0).epsilon(1e-9));
  rig.stroke({25, 0, 0.1}, {25, 0, 20.1});
  CHECK(rig.count<ReleaseEvent>() == 1);
  rig.stroke({25, 0, 20.1}, {25, 0, 4});
  CHECK(rig.count<HitEvent>() == 2);
}

TEST_CASE("contact is reported every fourth millisecond with depth and force") {
  SceneRig rig;
  rig.add(Plane{});
  rig.stroke({0, 0, 1}, {0, 0, -2});
  rig.events.clear();
  rig.rest(400, {0, 0, -2});
  CHECK(rig.events.size() == 100);
  for (const SceneEvent& event : rig.events) {
    const auto& contact = std::get<ContactEvent>(event);
    CHECK(contact.depth_m == tactus::test::approx(2e-3));
    check(contact.force_n, {0, 0, 1});
  }
}

TEST_CASE("a contact slower than 5 mm/s is no hit") {
  for (const double speed_mm_per_tick : {0.0045, 0.0055}) {
    SceneRig rig;
    rig.add(Plane{});
    rig.stroke({0, 0, 1}, {0, 0, -1}, speed_mm_per_tick);
    CHECK(rig.count<HitEvent>() == (speed_mm_per_tick > 0.005 ? 1u : 0u));
    CHECK(rig.count<ContactEvent>() > 0);
  }
}

#include "tests/core/haptic/approx.hpp"
#include "tests/core/haptic/scene/scene_rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::haptic;
using test::SceneRig;
using Kind = ContactEvent::Kind;

namespace {

void check(const Vec3& is, const Vec3& should, double tolerance = 1e-9) {
  INFO("is " << is.x << " " << is.y << " " << is.z << ", should be " << should.x << " " << should.y
             << " " << should.z);
  CHECK(norm(is - should) <= tolerance * std::max(norm(should), 1.0));
}

} // namespace

TEST_CASE("a sphere pushes along its radius with k times the depth") {
  SceneRig rig;
  rig.add(Sphere{0.02});
  check(rig.stroke({30, 0, 0}, {18, 0, 0}), {1, 0, 0});
  check(rig.stroke({30, 0, 0}, {18, 0, 0}), {1, 0, 0});
  SceneRig diagonal;
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
  SceneRig rig;
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
}

TEST_CASE("in one tick from one side of a thin disk to the other is a contact too") {
  SceneRig rig;
  rig.add(Disk{0.05, 0.006});
  rig.touch({3, 4, 30});
  check(rig.touch({3, 4, -30}), {0, 0, 18});
}

TEST_CASE("a plane pushes along its normal, wherever it lies") {
  SceneRig rig;
  const Vec3 normal = Vec3{1, 2, 2} * (1.0 / 3.0);
  rig.add(Plane{}, {normal * 0.01, Rotation::from_z_to({2, 4, 4})});
  check(rig.stroke(normal * 30, normal * 7), normal * 1.5);
  check(rig.stroke(normal * 7, normal * 7 + Vec3{10, -5, 0}), normal * 1.5);
  check(rig.stroke(normal * 7, normal * 12), {0, 0, 0});
}

TEST_CASE("a strike is one hit, at the tick in which the surface is passed") {
  SceneRig rig;
  const auto key = rig.add(Disk{0.05, 0.006}).key;
  for (int n = 0; n <= 80; ++n)
    rig.touch({25, 0, 20.1 - 0.25 * n});
  for (int n = 0; n < 200; ++n) // resting
    rig.touch({25, 0, 0.1});
  REQUIRE(rig.count(Kind::kHit) == 1);
  const ContactEvent& hit = rig.events.front();
  CHECK(hit.kind == Kind::kHit);
  CHECK(hit.key == key);
  CHECK(hit.time_s == doctest::Approx(57e-3).epsilon(1e-12));
  check(hit.point * 1e3, {25, 0, 6});
  check(hit.normal, {0, 0, 1});
  CHECK(hit.approach_m_per_s == doctest::Approx(0.25).epsilon(1e-9));
  CHECK(hit.slip_m_per_s == doctest::Approx(0).epsilon(1e-9));
  rig.stroke({25, 0, 0.1}, {25, 0, 20.1});
  CHECK(rig.count(Kind::kRelease) == 1);
  rig.stroke({25, 0, 20.1}, {25, 0, 4});
  CHECK(rig.count(Kind::kHit) == 2);
}

TEST_CASE("contact is reported every fourth millisecond with depth and force") {
  SceneRig rig;
  rig.add(Plane{});
  rig.stroke({0, 0, 1}, {0, 0, -2});
  rig.events.clear();
  for (int n = 0; n < 400; ++n)
    rig.touch({0, 0, -2});
  CHECK(rig.events.size() == 100);
  for (const ContactEvent& event : rig.events) {
    CHECK(event.kind == Kind::kContact);
    CHECK(event.depth_m == test::approx(2e-3));
    check(event.force_n, {0, 0, 1});
  }
}

TEST_CASE("a contact slower than 5 mm/s, or without a departure before, is no hit") {
  SceneRig slow;
  slow.add(Plane{});
  slow.stroke({0, 0, 0.1}, {0, 0, -1}, 0.004);
  CHECK(slow.count(Kind::kHit) == 0);
  CHECK(slow.count(Kind::kContact) > 0);
  SceneRig trembling;
  trembling.add(Plane{});
  trembling.stroke({0, 0, 5}, {0, 0, -0.05});
  for (int n = 0; n < 40; ++n) // 0.1 mm out and in again, 2 ms apart
    trembling.touch({0, 0, n % 4 < 2 ? -0.05 : 0.1});
  CHECK(trembling.count(Kind::kHit) == 1);
  CHECK(trembling.count(Kind::kRelease) == 10);
  for (int n = 0; n < 10; ++n)
    trembling.touch({0, 0, 0.3});
  trembling.stroke({0, 0, 0.3}, {0, 0, -0.1}, 0.1);
  CHECK(trembling.count(Kind::kHit) == 2);
}

#include "tests/approx.hpp"
#include "tests/core/haptic/scene/meshes.hpp"
#include "tests/core/haptic/scene/scene_rig.hpp"

#include <doctest/doctest.h>

#include <numbers>

// A tool of finite radius: a sphere about the handle.

using namespace tactus::haptic;
using tactus::Vec3;
using tactus::test::approx;
using test::random_point;
using test::SceneRig;

namespace {

constexpr double kPi = std::numbers::pi;

struct Raw {
  std::vector<Vec3> corners;
  std::vector<Triangle> triangles;
  [[nodiscard]] MeshSurface surface() const {
    return {std::make_shared<const TriangleMesh>(corners, triangles)};
  }
};

Raw tetrahedron() {
  return {{{0.01, 0.01, 0.01}, {-0.01, -0.01, 0.01}, {-0.01, 0.01, -0.01}, {0.01, -0.01, -0.01}},
          {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
}

/// A washer about z.
Raw ring(double inner_m, double outer_m, std::uint32_t segments) {
  Raw ring;
  for (std::uint32_t i = 0; i < segments; ++i) {
    const double a = 2 * kPi * i / segments;
    for (const double r : {inner_m, outer_m})
      ring.corners.push_back({r * std::cos(a), r * std::sin(a), 0});
    const std::uint32_t here = 2 * i, next = 2 * ((i + 1) % segments);
    ring.triangles.push_back({here, here + 1, next + 1});
    ring.triangles.push_back({here, next + 1, next});
  }
  return ring;
}

// Distances of a point outside, by other means than the scene's.

double distance(const Box& box, const Vec3& p) {
  return std::hypot(std::max(std::abs(p.x) - box.half.x, 0.0),
                    std::max(std::abs(p.y) - box.half.y, 0.0),
                    std::max(std::abs(p.z) - box.half.z, 0.0));
}

double distance(const Disk& disk, const Vec3& p) {
  return std::hypot(std::max(std::hypot(p.x, p.y) - disk.radius, 0.0),
                    std::max(std::abs(p.z) - disk.half_thickness, 0.0));
}

/// By trying points of each triangle about the best one so far, closer and closer.
double distance(const Raw& mesh, const Vec3& p) {
  double nearest = 1;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.corners[t[0]], u = mesh.corners[t[1]] - a, v = mesh.corners[t[2]] - a;
    const auto squared = [&](double s, double w) {
      const Vec3 from = p - a - u * s - v * w;
      return dot(from, from);
    };
    double s = 0, w = 0, least = squared(0, 0);
    for (double step = 0.5; step > 1e-9;) {
      double best_s = s, best_w = w;
      for (const auto& [ds, dw] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, -1}, {-1, 1}}) {
        const double next_s = s + ds * step, next_w = w + dw * step;
        if (next_s < 0 || next_w < 0 || next_s + next_w > 1 || squared(next_s, next_w) >= least)
          continue;
        least = squared(next_s, next_w);
        best_s = next_s, best_w = next_w;
      }
      if (best_s == s && best_w == w)
        step *= 0.5;
      s = best_s, w = best_w;
    }
    nearest = std::min(nearest, std::sqrt(least));
  }
  return nearest;
}

/// Presses the tool from all around to where its centre is 0.3 to 0.95 radii from the surface, and
/// compares the force at rest with k (R - distance).
template <class Solid> void check_pressed(const Solid& solid, const Shape& shape) {
  constexpr double kRadius_m = 5e-3;
  tactus::Random random(31);
  int tested = 0;
  while (tested < 60) {
    const Vec3 p = random_point(random, 0.03);
    if (distance_lower_bound(shape, p) < 0 && !std::holds_alternative<MeshSurface>(shape))
      continue;
    const double d = distance(solid, p);
    if (d < 0.3 * kRadius_m || d > 0.95 * kRadius_m)
      continue;
    // From far outside along the distance's gradient: the way there is free.
    const double h = 1e-6;
    const Vec3 gradient{distance(solid, p + Vec3{h, 0, 0}) - d,
                        distance(solid, p + Vec3{0, h, 0}) - d,
                        distance(solid, p + Vec3{0, 0, h}) - d};
    const Vec3 out = p + gradient * (2 * kRadius_m / norm(gradient));
    if (distance(solid, out) < 1.5 * kRadius_m)
      continue; // begins in the mesh
    SceneRig rig;
    rig.add(shape);
    rig.with_tool(kRadius_m * 1e3).stroke(out * 1e3, p * 1e3);
    CHECK(norm(rig.rest(40, p * 1e3)) == approx(500 * (kRadius_m - d)).epsilon(1e-6));
    // And the proxy touches the surface, without overlap.
    CHECK(distance(solid, rig.model.proxy()) == approx(kRadius_m).epsilon(1e-6));
    ++tested;
  }
}

} // namespace

TEST_CASE("at rest the force is k (R - distance): box, disk and mesh") {
  const Box box{{0.01, 0.006, 0.008}};
  check_pressed(box, box);
  const Disk disk{0.012, 0.003};
  check_pressed(disk, disk);
  check_pressed(tetrahedron(), tetrahedron().surface());
}

TEST_CASE("a sphere on a sphere or a plane is a point on a larger sphere or a higher plane") {
  tactus::Random random(41);
  SceneRig tool, point;
  tool.add(Sphere{0.015}, {}, {700, 2, 0.4});
  tool.add(Plane{}, {{0, -0.02, 0}, Rotation::from_z_to({0, 1, 0})}, {300, 0, 0.2});
  tool.with_tool(5);
  point.add(Sphere{0.015 + 0.005}, {}, {700, 2, 0.4});
  point.add(Plane{}, {{0, -0.02 + 0.005, 0}, Rotation::from_z_to({0, 1, 0})}, {300, 0, 0.2});
  Vec3 at{0, 60, 0}, aim = at;
  double worst = 0;
  for (int n = 0; n < 5000; ++n) {
    if (n % 60 == 0)
      aim = random_point(random, 30);
    at += (aim - at) * 0.05;
    worst = std::max(worst, norm(tool.touch(at) - point.touch(at)));
  }
  CHECK(worst < 1e-9); // the plane's height rounds differently
  CHECK(tool.count<HitEvent>() > 10);
  CHECK(tool.count<HitEvent>() == point.count<HitEvent>());
}

TEST_CASE(
    "where a tool first touches a convex solid, it is one radius away, and before it farther") {
  tactus::Random random(43);
  const Box box{{0.01, 0.004, 0.006}};
  const Disk disk{0.01, 0.002};
  const Shape shapes[] = {box, disk, tetrahedron().surface()};
  for (const Shape& shape : shapes)
    for (const double radius : {1e-5, 1e-3, 0.02}) {
      int hit_count = 0;
      for (int n = 0; n < 600; ++n) {
        const Vec3 from = random_point(random, 0.05), to = random_point(random, 0.05);
        WorkLimit work;
        if (!is_farther(shape, from, radius, work))
          continue;
        const auto found = crossing(shape, radius, from, to, work);
        const double until = found ? found->fraction : 1.0;
        for (int i = 0; i <= 64; ++i)
          REQUIRE(is_farther(shape, from + (to - from) * (until * i / 64), radius - 1e-12, work));
        if (!found)
          continue;
        ++hit_count;
        const Vec3 touch = from + (to - from) * until;
        CHECK(!is_farther(shape, touch, radius + 1e-12, work));
        CHECK(norm(found->normal) == doctest::Approx(1).epsilon(1e-12));
        CHECK(!is_farther(shape, touch - found->normal * radius, 1e-11, work)); // on the surface
      }
      CHECK(hit_count > 20);
    }
}

TEST_CASE("round a box's edge the tool's force is the gradient of its potential at every tick") {
  SceneRig rig;
  rig.add(Box{{0.02, 0.02, 0.02}});
  rig.with_tool(4);
  rig.stroke({10, 30, 0}, {10, 23, 0});
  double worst = 0;
  const auto check = [&](const Vec3& at, const Vec3& normal, double depth_mm) {
    worst = std::max(worst, norm(rig.touch(at) - normal * (0.5 * depth_mm)));
  };
  for (int n = 0; n <= 100; ++n) // along the face,
    check({10 + 0.1 * n, 23, 0}, {0, 1, 0}, 1);
  for (int n = 0; n <= 200; ++n) { // round the edge,
    const double a = kPi / 2 * n / 200;
    const Vec3 normal{std::sin(a), std::cos(a), 0};
    check(Vec3{20, 20, 0} + normal * 3, normal, 1);
  }
  for (int n = 0; n <= 100; ++n) // and down the side.
    check({23, 20 - 0.1 * n, 0}, {1, 0, 0}, 1);
  CHECK(worst < 1e-6);
}

TEST_CASE("a tool wider than a hole does not pass through it; a narrower one does") {
  const double apothem = 3 * std::cos(kPi / 64);
  for (const double side : {1.0, -1.0}) {
    SceneRig wide;
    wide.add(ring(0.003, 0.03, 64).surface());
    wide.with_tool(4).stroke({0.5, 0.2, 20 * side}, {0.1, -0.1, -20 * side});
    const Vec3 force = wide.rest(500, {0, 0, -20 * side});
    const double height = wide.proxy_mm().z * side;
    CHECK(height > std::sqrt(16 - 3 * 3) - 1e-3);
    CHECK(height < std::sqrt(16 - apothem * apothem) + 0.02);
    CHECK(force.z * side == doctest::Approx(0.5 * (20 + height)).epsilon(1e-3));
  }
  for (const double radius : {0.0, 2.9}) {
    SceneRig narrow;
    narrow.add(ring(0.003, 0.03, 64).surface());
    CHECK(norm(narrow.with_tool(radius).stroke({0, 0, 20}, {0, 0, -20})) == 0);
  }
}

TEST_CASE("a tool's hit lies on the surface, at the tick in which the sphere reaches it") {
  SceneRig rig;
  rig.add(Box{{0.02, 0.01, 0.02}});
  rig.with_tool(4);
  for (int n = 0; n <= 60; ++n) // 0.25 m/s down on the edge x = 20 mm, 2 mm beside it
    rig.touch({22, 24.1 - 0.25 * n, 0});
  REQUIRE(rig.count<HitEvent>() == 1);
  const auto& hit = std::get<HitEvent>(rig.events.front());
  // The centre is 4 mm from the edge at y = 10 + sqrt(16 - 4) mm: reached between ticks 42 and 43.
  CHECK(hit.time_s == doctest::Approx(43e-3));
  CHECK(norm(hit.point * 1e3 - Vec3{20, 10, 0}) < 1e-6);
  CHECK(hit.normal.y == doctest::Approx(std::sqrt(12.0) / 4).epsilon(0.02));
  CHECK(hit.approach_m_per_s == doctest::Approx(0.25 * hit.normal.y).epsilon(1e-6));
}

TEST_CASE("a tool that grows, or starts in a body or a mesh, is pushed out gently") {
  SceneRig rig;
  rig.add(Box{{0.02, 0.01, 0.02}}, {}, {4000, 0, 0});
  rig.add(test::flat_mesh(10, 0.1), {{0, 0.012, 0}, Rotation::from_z_to({0, 1, 0})}, {4000, 0, 0});
  rig.touch({0, 13, 0});
  rig.with_tool(4);
  double largest = 0;
  for (int n = 0; n < 300; ++n)
    largest = std::max(largest, norm(rig.touch({0, 13, 0})));
  CHECK(largest == doctest::Approx(1).epsilon(1e-9));
  CHECK(norm(rig.proxy_mm() - Vec3{0, 16, 0}) < 1e-6);
  CHECK(rig.count<HitEvent>() == 0);
  CHECK(norm(rig.stroke({0, 13, 0}, {0, 20, 0})) == 0);
  CHECK(norm(rig.stroke({0, 20, 0}, {0, 15, 0}) - Vec3{0, 4, 0}) < 1e-6);
}

TEST_CASE("a tool that shrinks rests on the body, or leaves it, also with friction") {
  SceneRig rig;
  rig.add(Plane{}, {}, {500, 0, 0.5});
  rig.with_tool(10);
  rig.stroke({0, 0, 15}, {0, 0, 8});
  CHECK(rig.touch({0, 0, 8}).z == approx(1).epsilon(1e-6)); // 2 mm
  rig.with_tool(9);
  rig.touch({0, 0, 8});
  CHECK(rig.touch({0, 0, 8}).z == approx(0.5).epsilon(1e-6)); // 1 mm
  rig.with_tool(7.5);
  CHECK(rig.touch({0, 0, 8}).z == 0);
  CHECK(rig.count<ReleaseEvent>() == 1);
}

TEST_CASE("a tool that grows in contact continues with the force of before") {
  SceneRig rig;
  rig.add(Plane{}, {}, {500, 0, 0});
  rig.with_tool(5);
  rig.stroke({0, 0, 15}, {0, 0, 0});
  CHECK(rig.touch({0, 0, 0}).z == approx(2.5).epsilon(1e-6));
  rig.with_tool(6);
  for (int n = 0; n < 30; ++n)
    CHECK(rig.touch({0, 0, 0}).z == approx(2.5).epsilon(1e-6)); // above 1 N: no more than before
  rig.stroke({0, 0, 0}, {0, 0, 3}); // asks for less than that: a body like any other
  CHECK(rig.stroke({0, 0, 3}, {0, 0, 0}).z == approx(3).epsilon(1e-6));
}

TEST_CASE("a body whose exit exceeds the work of a tick does not block the others") {
  SceneRig rig(160);
  rig.add(ring(1e-9, 0.05, 1000).surface()); // slivers that meet in the middle
  rig.add(Sphere{0.01}, {{0, 0, 0.003}, {}});
  rig.with_tool(4);
  rig.rest(3, {0, 0, 0.5});
  CHECK(norm(rig.model.proxy() - Vec3{0, 0, 0.003}) >= 0.014);
}

TEST_CASE("a tool too wide for the slit beside an edge stays on its side of it") {
  // Deep under the edge the point nearest to the handle lies beyond the slit.
  for (const bool round : {false, true}) {
    SceneRig rig;
    if (round)
      rig.add(Disk{0.03, 1e-3});
    else
      rig.add(Box{{0.03, 0.03, 1e-3}});
    // The half space x > 36.5 mm: the tool's centre passes at 32.5 mm at most, the edge at 34 mm.
    rig.add(Plane{}, {{0.0365, 0, 0}, Rotation::from_z_to({-1, 0, 0})});
    rig.with_tool(4);
    rig.stroke({30.2, 0, 8}, {30.2, 0, 4.9});
    CHECK(rig.rest(21, {30.2, 0, -1.9}).z > 0);
    CHECK(rig.model.proxy().z > 0);
  }
}

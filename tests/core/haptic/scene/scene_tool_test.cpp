#include "core/dsp/random.hpp"
#include "tests/core/haptic/approx.hpp"
#include "tests/core/haptic/scene/meshes.hpp"
#include "tests/core/haptic/scene/scene_rig.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <numbers>

// A tool of finite radius: a sphere about the handle.

using namespace tactus::haptic;
using test::approx;
using test::SceneRig;
using Kind = ContactEvent::Kind;

namespace {

constexpr double kPi = std::numbers::pi;

Vec3 random_point(tactus::Random& random, double reach) {
  const auto one = [&] { return reach * (2 * random.uniform() - 1); };
  const double x = one(), y = one();
  return {x, y, one()};
}

SceneRig& with_tool(SceneRig& rig, double radius_mm) {
  rig.scene.tool_radius_m = radius_mm * 1e-3;
  rig.publish();
  return rig;
}

/// Many points of a surface, for distances by brute force.
using Cloud = std::vector<Vec3>;

Cloud cloud_of(const Box& box, int n) {
  Cloud cloud;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0})
      for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) {
          Vec3 p;
          p[axis] = sign * box.half[axis];
          p[(axis + 1) % 3] = box.half[(axis + 1) % 3] * (2.0 * i / n - 1);
          p[(axis + 2) % 3] = box.half[(axis + 2) % 3] * (2.0 * j / n - 1);
          cloud.push_back(p);
        }
  return cloud;
}

Cloud cloud_of(const Disk& disk, int n) {
  Cloud cloud;
  for (int i = 0; i < 4 * n; ++i) {
    const double a = 2 * kPi * i / (4 * n), x = std::cos(a), y = std::sin(a);
    for (int j = 0; j <= n; ++j) {
      cloud.push_back({disk.radius * x, disk.radius * y, disk.half_thickness * (2.0 * j / n - 1)});
      for (const double sign : {-1.0, 1.0})
        cloud.push_back(
            {disk.radius * x * j / n, disk.radius * y * j / n, sign * disk.half_thickness});
    }
  }
  return cloud;
}

struct Raw {
  std::vector<Vec3> corners;
  std::vector<Triangle> triangles;
  [[nodiscard]] MeshSurface surface() const {
    return {std::make_shared<const TriangleMesh>(corners, triangles)};
  }
};

Cloud cloud_of(const Raw& mesh, int n) {
  Cloud cloud;
  for (const Triangle& t : mesh.triangles)
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        cloud.push_back(mesh.corners[t[0]] +
                        (mesh.corners[t[1]] - mesh.corners[t[0]]) * (static_cast<double>(i) / n) +
                        (mesh.corners[t[2]] - mesh.corners[t[0]]) * (static_cast<double>(j) / n));
  return cloud;
}

double distance(const Cloud& cloud, const Vec3& p) {
  double squared = 1;
  for (const Vec3& q : cloud)
    squared = std::min(squared, dot(p - q, p - q));
  return std::sqrt(squared);
}

Raw tetrahedron() {
  return {{{0.01, 0.01, 0.01}, {-0.01, -0.01, 0.01}, {-0.01, 0.01, -0.01}, {0.01, -0.01, -0.01}},
          {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
}

/// A flat washer about z.
Raw washer(double inner_m, double outer_m, std::uint32_t segments) {
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

/// Presses the tool from all around to where its centre is 0.3 to 0.95 radii from the surface, and
/// compares the force at rest with k (R - distance) along the distance's gradient.
void check_against(const Shape& shape, const Cloud& cloud, double radius_mm, double tolerance_n) {
  tactus::Random random(31);
  const double radius = radius_mm * 1e-3;
  int tested = 0;
  double worst = 0;
  for (int n = 0; n < 4000 && tested < 120; ++n) {
    const Vec3 p = random_point(random, 0.03);
    if (distance_lower_bound(shape, p) < 0 && !std::holds_alternative<MeshSurface>(shape))
      continue;
    const double d = distance(cloud, p);
    if (d < 0.3 * radius || d > 0.95 * radius)
      continue;
    // From far outside along the gradient: the way there is free.
    const double h = 1e-5;
    const Vec3 gradient =
        Vec3{distance(cloud, p + Vec3{h, 0, 0}) - d, distance(cloud, p + Vec3{0, h, 0}) - d,
             distance(cloud, p + Vec3{0, 0, h}) - d} *
        (1 / h);
    const Vec3 out = p + gradient * (2 * radius / norm(gradient));
    if (distance(cloud, out) < 1.5 * radius)
      continue; // in a hollow
    SceneRig rig;
    rig.add(shape);
    with_tool(rig, radius_mm).stroke(out * 1e3, p * 1e3);
    Vec3 force;
    for (int rest = 0; rest < 40; ++rest)
      force = rig.touch(p * 1e3);
    worst = std::max(worst, std::abs(norm(force) - 500 * (radius - d)));
    // And the proxy touches the surface, without overlap.
    CHECK(distance(cloud, rig.model.proxy()) == doctest::Approx(radius).epsilon(1e-3));
    ++tested;
  }
  CHECK(tested >= 60);
  CHECK(worst < tolerance_n);
}

} // namespace

TEST_CASE("a sphere on a sphere or a plane is a point on a larger sphere or a higher plane") {
  tactus::Random random(41);
  SceneRig tool, point;
  tool.add(Sphere{0.015}, {}, {700, 2, 0.4});
  tool.add(Plane{}, {{0, -0.02, 0}, Rotation::from_z_to({0, 1, 0})}, {300, 0, 0.2});
  with_tool(tool, 5);
  point.add(Sphere{0.015 + 0.005}, {}, {700, 2, 0.4});
  point.add(Plane{}, {{0, -0.02 + 0.005, 0}, Rotation::from_z_to({0, 1, 0})}, {300, 0, 0.2});
  Vec3 at{0, 60, 0}, aim = at;
  double worst = 0;
  for (int n = 0; n < 20000; ++n) {
    if (n % 60 == 0)
      aim = random_point(random, 30);
    at += (aim - at) * 0.05;
    worst = std::max(worst, norm(tool.touch(at) - point.touch(at)));
  }
  CHECK(worst < 1e-9); // the plane's height rounds differently
  CHECK(tool.count(Kind::kHit) > 20);
  CHECK(tool.count(Kind::kHit) == point.count(Kind::kHit));
}

TEST_CASE("at rest the force is k (R - distance), by brute force: box, disk and mesh" *
          doctest::skip(kSanitized)) {
  // Clouds with 0.1 mm of spacing h: the distance d is found too large by up to h^2/4d = 2 um.
  const Box box{{0.01, 0.006, 0.008}};
  check_against(box, cloud_of(box, 200), 5, 500 * 3e-6);
  const Disk disk{0.012, 0.003};
  check_against(disk, cloud_of(disk, 150), 5, 500 * 3e-6);
  check_against(tetrahedron().surface(), cloud_of(tetrahedron(), 250), 5, 500 * 3e-6);
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
      for (int n = 0; n < 3000; ++n) {
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
  with_tool(rig, 4);
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

TEST_CASE("a tool does not pass through a thin disk, however deep its centre is") {
  SceneRig rig;
  rig.add(Disk{0.05, 0.0005});
  with_tool(rig, 5);
  for (const double z : {5.0, 2.0, 0.0, -1.0, -4.0, -5.2, -8.0, -30.0})
    CHECK(norm(rig.stroke({3, 4, 20}, {3, 4, z}) - Vec3{0, 0, 0.5 * (5.5 - z)}) < 1e-9);
  CHECK(norm(rig.proxy_mm() - Vec3{3, 4, 5.5}) < 1e-8);
}

TEST_CASE("a tool wider than a hole does not pass through it; a narrower one does") {
  const double apothem = 3 * std::cos(kPi / 64);
  for (const double side : {1.0, -1.0}) {
    SceneRig wide;
    wide.add(washer(0.003, 0.03, 64).surface());
    with_tool(wide, 4).stroke({0.5, 0.2, 20 * side}, {0.1, -0.1, -20 * side});
    Vec3 force;
    for (int n = 0; n < 500; ++n)
      force = wide.touch({0, 0, -20 * side});
    const double height = wide.proxy_mm().z * side;
    CHECK(height > std::sqrt(16 - 3 * 3) - 1e-3);
    CHECK(height < std::sqrt(16 - apothem * apothem) + 0.02);
    CHECK(force.z * side == doctest::Approx(0.5 * (20 + height)).epsilon(1e-3));
  }
  for (const double radius : {0.0, 2.9}) {
    SceneRig narrow;
    narrow.add(washer(0.003, 0.03, 64).surface());
    CHECK(norm(with_tool(narrow, radius).stroke({0, 0, 20}, {0, 0, -20})) == 0);
  }
}

TEST_CASE("a flat mesh under a tool is a plane, inner edges included, from both sides") {
  for (const double side : {1.0, -1.0}) {
    SceneRig rig;
    rig.add(test::flat_mesh(40, 0.1), {{0, 0, 0.001}, Rotation::of(1, 0.2, -0.1, 0.3)});
    const Pose pose = rig.scene.bodies[0].pose;
    const auto world = [&](const Vec3& mm) { return pose.to_world(mm * 1e-3) * 1e3; };
    const Vec3 normal = pose.rotation.rotated({0, 0, side});
    with_tool(rig, 3).stroke(world({0, 0, 8 * side}), world({0, 0, 1.5 * side}));
    tactus::Random random(3);
    Vec3 at{0, 0, 1.5 * side}, to = at;
    double worst = 0;
    for (int n = 0; n < 4000; ++n) {
      if (n % 100 == 0) {
        to = random_point(random, 40);
        to.z = at.z;
      }
      at += (to - at) * 0.02;
      worst = std::max(worst, norm(rig.touch(world(at)) - normal * 0.75));
    }
    CHECK(worst < 1e-8);
  }
}

TEST_CASE("a tool's hit lies on the surface, at the tick in which the sphere reaches it") {
  SceneRig rig;
  rig.add(Box{{0.02, 0.01, 0.02}});
  with_tool(rig, 4);
  for (int n = 0; n <= 60; ++n) // 0.25 m/s down on the edge x = 20 mm, 2 mm beside it
    rig.touch({22, 24.1 - 0.25 * n, 0});
  REQUIRE(rig.count(Kind::kHit) == 1);
  const ContactEvent& hit = rig.events.front();
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
  with_tool(rig, 4);
  double largest = 0;
  for (int n = 0; n < 300; ++n)
    largest = std::max(largest, norm(rig.touch({0, 13, 0})));
  CHECK(largest == doctest::Approx(1).epsilon(1e-9));
  CHECK(norm(rig.proxy_mm() - Vec3{0, 16, 0}) < 1e-6);
  CHECK(rig.count(Kind::kHit) == 0);
  CHECK(norm(rig.stroke({0, 13, 0}, {0, 20, 0})) == 0);
  CHECK(norm(rig.stroke({0, 20, 0}, {0, 15, 0}) - Vec3{0, 4, 0}) < 1e-6);
}

TEST_CASE("a tool that shrinks rests on the body, or leaves it, also with friction") {
  SceneRig rig;
  rig.add(Plane{}, {}, {500, 0, 0.5});
  with_tool(rig, 10);
  rig.stroke({0, 0, 15}, {0, 0, 8});
  CHECK(rig.touch({0, 0, 8}).z == approx(1).epsilon(1e-6)); // 2 mm
  with_tool(rig, 9);
  rig.touch({0, 0, 8});
  CHECK(rig.touch({0, 0, 8}).z == approx(0.5).epsilon(1e-6)); // 1 mm
  with_tool(rig, 7.5);
  CHECK(rig.touch({0, 0, 8}).z == 0);
  CHECK(rig.count(Kind::kRelease) == 1);
}

TEST_CASE("a tool that grows in contact continues with the force of before") {
  SceneRig rig;
  rig.add(Plane{}, {}, {500, 0, 0});
  with_tool(rig, 5);
  rig.stroke({0, 0, 15}, {0, 0, 0});
  CHECK(rig.touch({0, 0, 0}).z == approx(2.5).epsilon(1e-6));
  with_tool(rig, 6);
  for (int n = 0; n < 30; ++n)
    CHECK(rig.touch({0, 0, 0}).z == approx(2.5).epsilon(1e-6)); // above 1 N: no more than before
  rig.stroke({0, 0, 0}, {0, 0, 3}); // asks for less than that: a body like any other
  CHECK(rig.stroke({0, 0, 3}, {0, 0, 0}).z == approx(3).epsilon(1e-6));
}

TEST_CASE("a body whose exit exceeds the work of a tick does not block the others") {
  SceneRig rig(160);
  Raw fan{{{0, 0, 0}}, {}};
  constexpr std::uint32_t kSlivers = 1000;
  for (std::uint32_t i = 0; i < kSlivers; ++i) {
    const double a = 2 * kPi * i / kSlivers;
    fan.corners.push_back({0.05 * std::cos(a), 0.05 * std::sin(a), 0});
    fan.triangles.push_back({0, 1 + i, 1 + (i + 1) % kSlivers});
  }
  rig.add(fan.surface());
  rig.add(Sphere{0.01}, {{0, 0, 0.003}, {}});
  with_tool(rig, 4);
  for (int n = 0; n < 3; ++n)
    rig.touch({0, 0, 0.5});
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
    with_tool(rig, 4);
    rig.stroke({30.2, 0, 8}, {30.2, 0, 4.9});
    for (int n = 0; n < 20; ++n)
      rig.touch({30.2, 0, -1.9});
    CHECK(rig.model.proxy().z > 0);
    CHECK(rig.touch({30.2, 0, -1.9}).z > 0);
  }
}

TEST_CASE("of two triangles met at the same fraction the last one in the mesh's order counts") {
  const std::vector<Vec3> roof{{0, -0.01, 0},    {0, 0.01, 0},     {-0.01, 0, -0.01},
                               {0.01, 0, -0.01}, {-0.01, 0, 0.01}, {0.01, 0, 0.01}};
  const Triangle left{0, 1, 2}, right{0, 1, 3}, left_up{0, 1, 4}, right_up{0, 1, 5};
  for (const bool right_last : {false, true}) {
    const auto normal_of = [&](const Triangle& one, const Triangle& other, double radius) {
      const TriangleMesh mesh(roof, std::array{right_last ? one : other, right_last ? other : one});
      WorkLimit work;
      const Vec3 above{0, 0, 0.02}, below{0, 0, -0.02};
      const auto hit = radius > 0 ? mesh.crossing(radius, above, below, work)
                                  : mesh.crossing(above, below, work);
      REQUIRE(hit.has_value());
      return hit->normal.x;
    };
    CHECK((normal_of(left, right, 0) > 0) == right_last);          // a point on the ridge
    CHECK((normal_of(left_up, right_up, 2e-3) < 0) == right_last); // a sphere in the valley
  }
}

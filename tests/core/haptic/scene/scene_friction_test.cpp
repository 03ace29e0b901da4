#include "tests/core/haptic/scene/meshes.hpp"
#include "tests/core/haptic/scene/scene_rig.hpp"

#include <doctest/doctest.h>

#include <functional>
#include <numbers>

// Friction of a tool of any radius on meshes of any fineness, on moving bodies, and on several at
// once: Coulomb's law at every tick, not in the mean.

using namespace tactus::haptic;
using tactus::Vec3;
using test::SceneRig;

namespace {

constexpr double kFriction = 0.3, kStiffness_n_per_m = 500;

/// The unit normal of a mesh where a tool at that centre touches it, found by the nearest point.
Vec3 normal_at(const TriangleMesh& mesh, const Vec3& centre, const Vec3& outwards) {
  WorkLimit work;
  const auto nearest = mesh.nearest(centre, 0.05, work);
  REQUIRE(nearest);
  const Vec3 gap = centre - nearest->point;
  const double distance = norm(gap);
  if (distance > 1e-6)
    return gap * (1 / distance);
  return dot(nearest->face_normal, outwards) < 0 ? -nearest->face_normal : nearest->face_normal;
}

struct Slide {
  double least = 1e9, most = 0; ///< tangential over normal force
  double largest_step_n = 0;    ///< of the force between two ticks
  double gained_m2 = 0;         ///< the most by which a move lengthened the spring, squared
  int ticks = 0;
};

/// Slides a tool with steps of that length, pressed in by the depth, along a curve 1.2 mm inside of
/// `surface`, and measures wherever the proxy moves at more than 1 mm/s.
Slide slide(SceneRig& rig, const TriangleMesh& mesh, const std::function<Vec3(double)>& path_mm,
            const std::function<Vec3(const Vec3&)>& outwards, double step_mm, double begin_mm,
            int ticks) {
  const Vec3 first = path_mm(0), out = outwards(first);
  rig.stroke(first + out * 12, first);
  double along = 0;
  for (; along < begin_mm; along += std::max(step_mm, 0.05))
    rig.touch(path_mm(along));
  Slide result;
  Vec3 force_before = rig.touch(path_mm(along)), proxy_before = rig.model.proxy();
  for (int n = 0; n < ticks; ++n) {
    along += step_mm;
    const Vec3 hand = path_mm(along);
    const Vec3 force = rig.touch(hand), proxy = rig.model.proxy();
    const Vec3 normal = normal_at(mesh, proxy, outwards(hand));
    const double pressed = dot(force, normal), drag = norm(force - normal * pressed);
    if (norm(proxy - proxy_before) > 1e-6) {
      result.least = std::min(result.least, drag / pressed);
      result.most = std::max(result.most, drag / pressed);
      ++result.ticks;
    }
    result.largest_step_n = std::max(result.largest_step_n, norm(force - force_before));
    const Vec3 now = proxy - hand * 1e-3, without_move = proxy_before - hand * 1e-3;
    result.gained_m2 = std::max(result.gained_m2, dot(now, now) - dot(without_move, without_move));
    force_before = force;
    proxy_before = proxy;
  }
  return result;
}

Vec3 on_sphere(double radius, double along) {
  const double longitude = along / radius, latitude = 0.6 * std::sin(0.7 * longitude + 0.5);
  return Vec3{std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
              std::sin(latitude)} *
         radius;
}

struct Case {
  double tool_mm, depth_mm, step_mm;
};

/// On a ball of 25 mm, along a wavy line about its equator.
void check_ball(const MeshSurface& ball, const Case& at, int ticks, double tolerance = 0.1) {
  CAPTURE(ball.mesh->size());
  CAPTURE(at.tool_mm);
  CAPTURE(at.depth_mm);
  CAPTURE(at.step_mm);
  SceneRig rig;
  rig.add(ball, {}, {kStiffness_n_per_m, 0, kFriction});
  rig.with_tool(at.tool_mm);
  const double radius = 25 + at.tool_mm - at.depth_mm;
  const auto outwards = [](const Vec3& p) { return p * (1 / norm(p)); };
  const auto path = [radius](double along) { return on_sphere(radius, along); };
  const Slide found = slide(rig, *ball.mesh, path, outwards, at.step_mm, at.depth_mm, ticks);
  CHECK(found.least > kFriction * (1 - tolerance));
  CHECK(found.most < kFriction * (1 + tolerance));
  if (at.step_mm > 0.005)
    CHECK(found.ticks > ticks * 9 / 10);
  CHECK(found.gained_m2 < 1e-15);
}

void check_plate(const MeshSurface& plate, const Case& at, int ticks) {
  CAPTURE(plate.mesh->size());
  CAPTURE(at.tool_mm);
  CAPTURE(at.depth_mm);
  CAPTURE(at.step_mm);
  SceneRig rig;
  rig.add(plate, {}, {kStiffness_n_per_m, 0, kFriction});
  rig.with_tool(at.tool_mm);
  const auto path = [&](double along) {
    return Vec3{-20 + 0.8 * along, -12 + 0.6 * along, at.tool_mm - at.depth_mm};
  };
  const Slide found = slide(
      rig, *plate.mesh, path,
      [](const Vec3&) {
        return Vec3{0, 0, 1};
      },
      at.step_mm, at.depth_mm, std::min(ticks, static_cast<int>(40 / at.step_mm)));
  CHECK(found.least == doctest::Approx(kFriction).epsilon(1e-6));
  CHECK(found.most == doctest::Approx(kFriction).epsilon(1e-6));
  CHECK(found.largest_step_n < 1e-5);
  CHECK(found.gained_m2 < 1e-15);
}

const MeshSurface& ball_50000() {
  static const MeshSurface mesh = test::mesh_sphere(0.025, 159, 158);
  return mesh;
}
const MeshSurface& ball_5000() {
  static const MeshSurface mesh = test::mesh_sphere(0.025, 50, 51);
  return mesh;
}

} // namespace

TEST_CASE("a tool that slides over a ball of 50000 triangles feels mu F_n at every tick") {
  for (const double tool_mm : {0.0, 1.0, 8.0, 10.0})
    for (const double step_mm : {0.002, 0.2})
      check_ball(ball_50000(), {tool_mm, 2, step_mm}, 150);
  check_ball(ball_50000(), {8, 6, 1}, 40);
  check_ball(ball_50000(), {8, 0.5, 0.02}, 300);
}

TEST_CASE("on a coarse ball, too, each facet and each rounded edge drags by mu F_n") {
  for (const double tool_mm : {0.0, 1.0, 4.0, 8.0, 10.0})
    for (const double depth_mm : {0.5, 2.0, 6.0})
      check_ball(ball_5000(), {tool_mm, depth_mm, 0.05}, 200);
}

TEST_CASE("on a plate of irregular triangles no edge is felt in the drag") {
  const auto plate = test::flat_mesh(60, 0.06, 0.3);
  for (const double tool_mm : {0.0, 1.0, 8.0})
    for (const double step_mm : {0.01, 0.3})
      check_plate(plate, {tool_mm, 2, step_mm}, 300);
}

TEST_CASE("for all tools, depths and speeds, on balls and plates of 500 to 500000 triangles, "
          "friction is mu F_n at every tick" *
          doctest::test_suite("slow")) {
  const MeshSurface balls[] = {test::mesh_sphere(0.025, 16, 17),
                               ball_5000(),
                               ball_50000(),
                               test::mesh_sphere(0.025, 500, 501),
                               test::mesh_sphere(0.025, 160, 159, 0.3),
                               test::mesh_sphere(0.025, 500, 501, 0.3)};
  const MeshSurface plates[] = {test::flat_mesh(10, 0.06, 0.3), test::flat_mesh(200, 0.06, 0.3)};
  for (const double tool_mm : {0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 10.0})
    for (const double depth_mm : {0.5, 2.0, 6.0})
      for (const double step_mm : {0.002, 0.02, 0.2, 1.0}) {
        for (const MeshSurface& ball : balls)
          check_ball(ball, {tool_mm, depth_mm, step_mm}, 300);
        for (const MeshSurface& plate : plates)
          check_plate(plate, {tool_mm, depth_mm, step_mm}, 300);
      }
}

TEST_CASE("a hand that turns back or rests on a fine mesh is held by the same anchor") {
  SceneRig rig; // touched at its equator
  rig.add(ball_50000(), {{}, Rotation::of(1, 1, 0, 0)}, {kStiffness_n_per_m, 0, kFriction});
  rig.with_tool(8);
  rig.stroke({0, 0, 40}, {0, 0, 31});
  for (int n = 0; n < 400; ++n)
    rig.touch({0.01 * n, 0, 31});
  const Vec3 anchor = rig.model.proxy();
  CHECK(rig.rest(5000, {3.99, 0, 31}) == rig.touch({3.99, 0, 31}));
  for (int n = 0; n < 60; ++n) // 0.6 of the cone's 1.2 mm
    rig.touch({3.99 - 0.01 * n, 0, 31});
  CHECK(rig.model.proxy() == anchor);
  CHECK(norm(rig.touch({3.99, 0, 31}) - (anchor - Vec3{3.99e-3, 0, 31e-3}) * kStiffness_n_per_m) <
        1e-8);
}

TEST_CASE("the force of a tool wider than its depth is as continuous as the hand's motion") {
  // On a facet the force follows the hand; on an edge's rounding of radius R the normal turns by
  // the way over R, and the force by less than k times the way as long as the depth is below R.
  SceneRig rig;
  rig.add(ball_50000(), {}, {kStiffness_n_per_m, 0, kFriction});
  rig.with_tool(8);
  const auto path = [](double along) { return on_sphere(31, along); };
  const Slide found = slide(
      rig, *ball_50000().mesh, path, [](const Vec3& p) { return p * (1 / norm(p)); }, 0.02, 2,
      1500);
  CHECK(found.largest_step_n < kStiffness_n_per_m * 0.025e-3);
}

TEST_CASE("a mesh that moves or turns under a resting hand drags it by mu F_n at every tick") {
  for (const bool turns : {false, true}) {
    CAPTURE(turns);
    SceneRig rig;
    rig.add(ball_50000(), {}, {kStiffness_n_per_m, 0, kFriction});
    rig.with_tool(8);
    rig.stroke({0, 0, 40}, {0, 0, 31});
    rig.scene.bodies[0].glide_s = 0.4;
    if (turns)
      rig.scene.bodies[0].pose.rotation = Rotation::of(std::cos(0.4), 0.1, std::sin(0.4), 0);
    else
      rig.scene.bodies[0].pose.position = {0.006, 0.002, 0};
    rig.publish();
    for (int n = 0; n < 400; ++n) {
      const Vec3 force = rig.touch({0, 0, 31});
      if (n < 80)
        continue;
      const Vec3 normal = rig.model.touches()[0].normal;
      const double pressed = dot(force, normal), drag = norm(force - normal * pressed);
      CHECK(drag / pressed == doctest::Approx(kFriction).epsilon(0.01));
      CHECK(force.x > 0); // the way that the surface goes
    }
  }
}

TEST_CASE("in a groove the friction of both walls adds up: mu (N1 + N2)") {
  // Walls at 45 degrees carry N/sqrt 2 each.
  for (const double tool_mm : {0.0, 4.0}) {
    SceneRig rig;
    for (const double side : {-1.0, 1.0})
      rig.add(Plane{}, {{}, Rotation::from_z_to({side, 0, 1})}, {500, 0, kFriction});
    rig.with_tool(tool_mm);
    const double bottom = tool_mm * std::numbers::sqrt2;
    rig.stroke({0, 0, bottom + 5}, {0, 0, bottom - 2});
    for (int n = 0; n <= 400; ++n) {
      const Vec3 force = rig.touch({0, 0.01 * n, bottom - 2});
      const double drag = 0.5 * std::min(0.01 * n, kFriction * 2 * std::numbers::sqrt2);
      CHECK(norm(force - Vec3{0, -drag, 1}) < 1e-6);
    }
  }
}

TEST_CASE("a smooth body that slides past the tool does not drag it over a rough one") {
  for (const bool wall_first : {false, true})
    for (const double tool_mm : {0.0, 4.0}) {
      CAPTURE(wall_first);
      SceneRig rig;
      rig.add(Plane{}, {}, {500, 0, kFriction});
      rig.add(Plane{}, {{}, Rotation::from_z_to({-1, 0, 0})}, {500, 0, 0});
      rig.with_tool(tool_mm);
      const Vec3 corner{-tool_mm, 0, tool_mm}, end = corner + Vec3{1, 0, -1};
      const Vec3 begin = corner + (wall_first ? Vec3{1, 0, 5} : Vec3{-5, 0, -1});
      rig.stroke(corner + Vec3{-5, 0, 5}, begin);
      const Vec3 expected = rig.stroke(begin, end);
      REQUIRE(rig.model.touches().size() == 2);
      rig.glide(1, {0, 0.05, 0}, 0.5); // along y, in its own plane
      for (int n = 0; n < 600; ++n)
        CHECK(norm(rig.touch(end) - expected) < 1e-9);
    }
}

TEST_CASE("a body that pushes the tool over a rough floor is felt, and told, from the first tick") {
  SceneRig rig;
  rig.add(Plane{}, {}, {500, 0, kFriction});
  rig.add(Box{{0.01, 0.01, 0.01}}, {{-0.02, 0, 0.01}, {}}, {500, 0, 0});
  rig.with_tool(2);
  rig.stroke({0, 0, 6}, {0, 0, 1}); // 1 mm into the floor, 8 mm beside the box
  rig.glide(1, {-0.0118, 0, 0.01}, 0.1);
  rig.rest(105, {0, 0, 1}); // the box has pushed the proxy by 0.2 mm
  CHECK(rig.proxy_mm().x == doctest::Approx(0.2).epsilon(1e-6));
  CHECK(rig.count<HitEvent>() == 2);
  double wall_n = 0;
  for (const SceneEvent& event : rig.events)
    if (const auto* const contact = std::get_if<ContactEvent>(&event); contact && contact->key == 2)
      wall_n = contact->force_n.x;
  CHECK(wall_n == doctest::Approx(0.1).epsilon(1e-6));
}

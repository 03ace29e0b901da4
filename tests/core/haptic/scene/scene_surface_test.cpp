#include "tests/core/haptic/scene/meshes.hpp"
#include "tests/core/haptic/scene/scene_rig.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <numbers>

// Sliding, sticking, edges and meshes.

using namespace tactus::haptic;
using tactus::Vec3;
using test::random_point;
using test::SceneRig;

namespace {

double error(const Vec3& is, const Vec3& should) { return norm(is - should); }

} // namespace

TEST_CASE("the force of a smooth sphere is the gradient of a potential and returns all work") {
  SceneRig rig;
  rig.add(Sphere{0.02}, {{0.003, -0.002, 0.001}, {}});
  const Vec3 centre{3, -2, 1};
  rig.stroke(centre + Vec3{0, 0, 25}, centre + Vec3{0, 0, 19});
  double worst = 0, work = 0;
  Vec3 before = centre + Vec3{0, 0, 19}, force_before = rig.touch(before);
  for (int n = 1; n <= 20000; ++n) { // a knot that ends where it began, always inside
    const double a = 2 * std::numbers::pi * n / 20000, depth = 1 + 0.8 * std::sin(5 * a);
    const Vec3 direction{std::sin(2 * a), std::sin(3 * a), std::cos(a) + 0.2};
    const Vec3 out = direction * (1 / norm(direction)), here = centre + out * (20 - depth);
    const Vec3 force = rig.touch(here);
    worst = std::max(worst, error(force, out * (0.5 * depth)));
    work += 0.5e-3 * dot(force + force_before, here - before);
    before = here;
    force_before = force;
  }
  CHECK(worst < 1e-9);
  // Trapezia over 20000 steps; what went in and out is some mJ.
  CHECK(std::abs(work) < 1e-8);
}

TEST_CASE("on a rough plane the hand sticks within the friction cone, then slips with mu F_n") {
  SceneRig rig;
  rig.add(Plane{}, {}, {800, 0, 0.4});
  rig.stroke({0, 0, 5}, {0, 0, -2});
  for (int n = 0; n <= 300; ++n) {
    const double x = 0.01 * n; // mm; the cone's edge lies at 0.4 * 2 mm
    CHECK(error(rig.touch({x, 0, -2}), {-0.8 * std::min(x, 0.8), 0, 1.6}) < 1e-9);
  }
  // Turning back: held again where it stands, until the cone's other edge.
  for (int n = 0; n <= 300; ++n) {
    const double x = 3 - 0.01 * n, held = 3 - 0.8;
    CHECK(error(rig.touch({x, 0, -2}), {-0.8 * std::max(x - held, -0.8), 0, 1.6}) < 1e-9);
  }
}

TEST_CASE("sticking friction does not creep, on flat and on curved faces") {
  SceneRig flat, curved;
  flat.add(Plane{}, {}, {500, 0, 0.5});
  curved.add(Sphere{0.02}, {}, {500, 0, 0.5});
  flat.stroke({0, 0, 5}, {0, 0, -2});
  curved.stroke({0, 0, 25}, {0, 0, 18});
  const Vec3 begun = flat.stroke({0, 0, -2}, {0.7, 0.3, -2});
  const Vec3 begun_curved = curved.stroke({0, 0, 18}, {0.7, 0.3, 18});
  CHECK(begun_curved.x < -0.3);
  CHECK(flat.rest(20000, {0.7, 0.3, -2}) == begun);
  CHECK(curved.rest(20000, {0.7, 0.3, 18}) == begun_curved);
}

TEST_CASE("on a rough sphere the tangential force is mu times the normal force") {
  SceneRig rig;
  rig.add(Sphere{0.02}, {}, {500, 0, 0.3});
  rig.stroke({0, 0, 25}, {0, 0, 18});
  for (int n = 0; n <= 400; ++n) {
    const double a = n * 2e-3;
    const Vec3 force = rig.touch({18 * std::sin(a), 0, 18 * std::cos(a)});
    const Vec3 out = rig.model.touches()[0].normal;
    const double normal = dot(force, out), drag = norm(force - out * normal);
    if (n >= 150)
      CHECK(drag / normal == doctest::Approx(0.3).epsilon(1e-6));
  }
}

TEST_CASE("over a box's edge the force ends without ever rising") {
  SceneRig rig;
  rig.add(Box{{0.03, 0.01, 0.02}});
  CHECK(error(rig.stroke({0, 15, 0}, {0, 9, 0}), {0, 0.5, 0}) < 1e-9);
  for (int n = 0; n <= 1000; ++n) {
    const Vec3 force = rig.touch({0.04 * n, 9, 0.01 * n});
    if (n != 750) // at the very edge either is right
      CHECK(error(force, n < 750 ? Vec3{0, 0.5, 0} : Vec3{}) < 1e-9);
    CHECK(norm(force) <= 0.5 + 1e-9);
  }
}

TEST_CASE("in a corner of planes the proxy stays in all of them") {
  SceneRig rig;
  const Vec3 a{1, 0, 0}, b{0, 1, 0}, c = Vec3{-0.2, -0.3, 1} * (1 / std::sqrt(1.13));
  for (const Vec3& normal : {a, b, c})
    rig.add(Plane{}, {{}, Rotation::from_z_to(normal)});
  const Vec3 force = rig.stroke({10, 12, 14}, {-1, -2, -8}, 0.4);
  CHECK(norm(rig.proxy_mm()) < 1e-8); // the corner itself
  CHECK(error(force, Vec3{1, 2, 8} * 0.5) < 1e-8);
  // Out along the edge of the first two: x and y still held.
  CHECK(error(rig.stroke({-1, -2, -8}, {-1, -2, 5}), {0.5, 1, 0}) < 1e-8);
}

TEST_CASE("a flat mesh is a plane from both sides, inner edges included, for a point and a tool") {
  for (const double tool_mm : {0.0, 3.0})
    for (const double side : {1.0, -1.0}) {
      SceneRig rig;
      rig.add(test::flat_mesh(40, 0.1), {{0, 0, 0.001}, Rotation::of(1, 0.2, -0.1, 0.3)});
      const Pose pose = rig.scene.bodies[0].pose;
      const auto world = [&](const Vec3& mm) { return pose.to_world(mm * 1e-3) * 1e3; };
      const Vec3 normal = pose.rotation.rotated({0, 0, side});
      Vec3 at{0, 0, (tool_mm - 1.5) * side}, to = at;
      rig.with_tool(tool_mm).stroke(world({0, 0, 8 * side}), world(at));
      tactus::Random random(3);
      double worst = 0;
      for (int n = 0; n < 5000; ++n) {
        if (n % 100 == 0) {
          to = random_point(random, 45 - tool_mm);
          to.z = at.z;
        }
        at += (to - at) * 0.02;
        worst = std::max(worst, error(rig.touch(world(at)), normal * 0.75));
      }
      CHECK(worst < 1e-8);
    }
}

TEST_CASE("along the edges of its triangles, too, a flat mesh holds the proxy") {
  SceneRig rig;
  rig.add(test::flat_mesh(40, 0.1));
  rig.stroke({0, 0, 5}, {0, 0, -1}); // exactly on a corner of the grid
  for (int n = 0; n <= 8000; ++n) {  // along x, and back along the diagonals
    const double s = n <= 4000 ? 0.01 * n : 80 - 0.01 * n;
    REQUIRE(error(rig.touch({s, n <= 4000 ? 0 : s - 40, -1}), {0, 0, 0.5}) < 1e-9);
  }
}

TEST_CASE("a sphere of 50000 triangles feels like the sphere, as far as it is one") {
  SceneRig mesh, sphere;
  const auto surface = test::mesh_sphere(0.05, 159, 158);
  REQUIRE(surface.mesh->size() > 49000);
  mesh.add(surface);
  sphere.add(Sphere{0.05});
  mesh.stroke({0, 0, 60}, {0, 0, 48});
  sphere.stroke({0, 0, 60}, {0, 0, 48});
  // Edges of 2 mm: a facet lies up to h^2/8R = 10 um below the sphere, turned by up to h/2R.
  double worst = 0, max_direction_change = 0, largest_step = 0;
  Vec3 before{0, 0, 1};
  for (int n = 0; n <= 6000; ++n) {
    const double a = n * 4e-4, b = n * 7e-4;
    const Vec3 at{48 * std::sin(a) * std::cos(b), 48 * std::sin(a) * std::sin(b), 48 * std::cos(a)};
    const Vec3 f = mesh.touch(at), g = sphere.touch(at);
    worst = std::max(worst, std::abs(norm(f) - norm(g)));
    max_direction_change = std::max(max_direction_change, norm(cross(f, g)) / (norm(f) * norm(g)));
    if (n > 0)
      largest_step = std::max(largest_step, norm(f - before));
    before = f;
  }
  CHECK(worst < 500 * 15e-6);
  CHECK(max_direction_change < 0.025);
  // Over an edge of the mesh the proxy goes at most by the turn of the normal times the depth.
  CHECK(largest_step < 500 * 2e-3 * 0.05);
}

TEST_CASE("absurd positions and bodies give finite forces") {
  SceneRig rig;
  rig.add(Sphere{1e-5}, {}, {1e5, 1000, 10});
  rig.add(Box{{10, 1e-5, 10}}, {{0, 1e-5, 0}, {}}, {1e5, 1000, 10});
  rig.add(Disk{10, 5e-6}, {{1e3, -1e3, 1e3}, {}}, {0, 0, 0});
  rig.add(MeshSurface{
      std::make_shared<const TriangleMesh>(std::span<const Vec3>{}, std::span<const Triangle>{})});
  const double infinity = std::numeric_limits<double>::infinity();
  const double values[] = {0, 1, -1e-300, 1e300, -infinity, std::nan(""), 1e9, 5e-324, 3};
  for (const double x : values)
    for (const double y : values)
      for (const double z : values)
        CHECK(is_finite(rig.touch({x, y, z})));
  CHECK(is_finite(rig.model.proxy()));
}

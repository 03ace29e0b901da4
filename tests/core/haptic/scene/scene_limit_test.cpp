#include "tests/core/haptic/scene/meshes.hpp"
#include "tests/core/haptic/scene/scene_rig.hpp"

#include <doctest/doctest.h>

#include <initializer_list>
#include <numbers>

// A tick's work is limited. What is not done waits for the next ticks, and nothing is passed
// through meanwhile.

using namespace tactus::haptic;
using tactus::Vec3;
using test::random_point;
using test::random_pose;
using test::SceneRig;

namespace {

/// Solids, sheets and a ball that overlap each other, rough and smooth.
void fill(SceneRig& rig, std::uint64_t seed) {
  tactus::Random random(seed);
  static const auto sheet = test::flat_mesh(12, 0.05);
  static const auto ball = test::mesh_sphere(0.02, 24, 24);
  for (int i = 0; i < 20; ++i) {
    const Pose pose = random_pose(random, 0.04);
    const double size = 0.004 + 0.01 * random.uniform();
    const Material material{500, 0, i % 3 == 0 ? 0.0 : random.uniform()};
    switch (i % 5) {
    case 0:
      rig.add(Sphere{size}, pose, material);
      break;
    case 1:
      rig.add(Box{{size, 0.3 * size, 0.6 * size}}, pose, material);
      break;
    case 2:
      rig.add(Disk{size, 0.1 * size}, pose, material);
      break;
    case 3:
      rig.add(sheet, pose, material);
      break;
    default:
      rig.add(ball, pose, material);
    }
  }
}

/// Whether a straight motion of the tool's centre is free of every body where it lies now: by the
/// bare test, body by body.
bool is_free(const Scene& scene, const Vec3& from, const Vec3& to) {
  for (const Body& body : scene.bodies) {
    WorkLimit work;
    if (crossing(body.shape, scene.tool_radius_m, body.pose.to_local(from), body.pose.to_local(to),
                 work))
      return false;
  }
  return true;
}

bool is_outside(const Scene& scene, const Vec3& p) {
  for (const Body& body : scene.bodies) {
    WorkLimit work;
    const Vec3 local = body.pose.to_local(p);
    if (std::holds_alternative<MeshSurface>(body.shape)
            ? scene.tool_radius_m > 0 &&
                  !is_farther(body.shape, local, scene.tool_radius_m - 1e-9, work)
            : !is_farther(body.shape, local, std::max(scene.tool_radius_m - 1e-9, 1e-15), work))
      return false;
  }
  return true;
}

using Limits = std::initializer_list<std::int64_t>;

void check_never_inside(Limits limits, std::uint64_t seeds, int ticks) {
  for (const std::int64_t limit : limits)
    for (const double tool_m : {0.0, 0.002}) {
      std::uint64_t incomplete = 0;
      for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        tactus::Random random(seed + 100);
        SceneRig rig(limit);
        rig.scene.tool_radius_m = tool_m;
        fill(rig, seed);
        for (Body& body : rig.scene.bodies) // nothing where the hand begins
          if (norm(body.pose.position) < 0.035)
            body.pose.position = body.pose.position * (0.05 / norm(body.pose.position));
        // A closed room around it all, and the hand leaps far out of it.
        rig.add(test::mesh_sphere(0.12, 40, 40));
        rig.touch({0, 0, 0});
        REQUIRE(is_outside(rig.scene, rig.model.proxy()));
        for (int n = 0; n < ticks; ++n) {
          const std::size_t released = rig.count<ReleaseEvent>();
          const Vec3 force = rig.touch(random_point(random, n % 7 == 0 ? 300 : 60));
          // What was not searched to the end is not told as a release.
          REQUIRE((rig.model.complete() || rig.count<ReleaseEvent>() == released));
          REQUIRE(is_finite(force));
          REQUIRE(is_outside(rig.scene, rig.model.proxy()));
          REQUIRE(norm(rig.model.proxy()) < 0.12);
          REQUIRE(norm(force) <= 500 * norm(rig.model.proxy() - rig.last_m()) * (1 + 1e-6) + 1e-9);
          incomplete += !rig.model.complete();
        }
      }
      if (limit <= 1000)
        CHECK(8 * incomplete > seeds * static_cast<std::uint64_t>(ticks));
    }
}

/// From outside of everything along one straight motion, in one tick, then at rest.
void check_arrival(Limits limits, std::uint64_t seeds, int targets) {
  for (const std::int64_t limit : limits) {
    int compared = 0, stuck = 0;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      tactus::Random random(seed + 200);
      SceneRig little(limit), plenty(WorkLimit::kUnlimited), rough(limit);
      for (auto* rig : {&little, &plenty, &rough}) {
        fill(*rig, seed);
        for (Body& body : rig->scene.bodies) // what friction holds back depends on the path
          body.material.friction = rig == &rough ? 0.8 : 0.0;
        rig->publish();
      }
      for (int n = 0; n < targets; ++n) {
        const Vec3 out = random_point(random, 1) * 1e3, in = random_point(random, 40);
        const auto arrive = [&](SceneRig& rig, int ticks) {
          rig.model.begin();
          rig.touch(out);
          const Vec3 force = rig.rest(ticks, in);
          REQUIRE(is_outside(rig.scene, rig.model.proxy()));
          return force;
        };
        const Vec3 force = arrive(little, 600), expected = arrive(plenty, 60);
        for (auto* rig : {&little, &plenty}) { // it could come no nearer straight ahead
          const Vec3 at = rig->model.proxy(), ahead = in * 1e-3 - at;
          if (norm(ahead) > 1e-6)
            CHECK(!is_free(rig->scene, at, at + ahead));
          CHECK(norm(rig == &little ? force : expected) <= 500 * norm(ahead) * (1 + 1e-6) + 1e-9);
        }
        compared += norm(little.model.proxy() - plenty.model.proxy()) < 1e-6 &&
                    norm(force - expected) < 1e-3;
        // Friction does not hold a proxy that has not arrived at the faces that it touches.
        arrive(rough, 600);
        stuck += !rough.model.complete();
        for (const Touch& touch : rough.model.touches())
          if (limit >= 1000)
            CHECK(std::abs(dot(touch.normal, rough.model.proxy() - touch.point)) < 1e-9);
      }
    }
    // Two paths into a heap of bodies may end in different hollows of it; most end in the same, but
    // for an absurd limit, which cuts the path into many. Some hollows take more than 1000 units
    // even at rest.
    CAPTURE(limit);
    const double all = static_cast<double>(seeds) * targets;
    CHECK(compared >= (limit < 1000 ? 0.58 : 0.9) * all);
    CHECK(stuck <= (limit < 1000 ? 1 : 0.08) * all);
  }
}

} // namespace

// Absurdly little up to plenty: 300 units are some thirty tests of one body.

TEST_CASE("for any work limit the proxy is never inside a body or beyond a closed mesh") {
  check_never_inside({40, 1000, 24000}, 1, 200);
}

TEST_CASE("in many scenes and for any work limit the proxy is never inside a body" *
          doctest::test_suite("slow")) {
  check_never_inside({40, 300, 1000, 4000, 24000}, 4, 600);
}

TEST_CASE("under a work limit the proxy arrives where it would without one, when the hand rests") {
  check_arrival({1000}, 1, 20);
}

TEST_CASE("in many scenes, under any work limit, the proxy arrives where it would without one" *
          doctest::test_suite("slow")) {
  check_arrival({300, 1000, 4000}, 6, 40);
}

TEST_CASE("an exhausted sweep ends at once and is not complete") {
  Body ball;
  ball.shape = Sphere{0.01};
  std::vector<Obstacle> obstacles;
  for (std::size_t slot = 0; slot < Scene::kMaxBodies; ++slot)
    obstacles.push_back({&ball, {}, slot, bounds_of(ball.shape, {})});
  for (const double tool_m : {0.0, 0.003}) {
    WorkLimit little(30), plenty;
    const auto stop = Proxy::sweep({0.1, 0, 0}, {-0.1, 0, 0}, {obstacles, tool_m, little});
    CHECK(!stop.complete);
    CHECK(little.exhausted());
    CHECK(little.remaining() > -60);
    const auto whole = Proxy::sweep({0.1, 0, 0}, {-0.1, 0, 0}, {obstacles, tool_m, plenty});
    CHECK(whole.complete);
    CHECK(whole.touch.slot == 0);
    CHECK(whole.fraction == doctest::Approx((0.09 - tool_m) / 0.2));
  }
}

TEST_CASE("a body whose motion always exceeds the work limit does not block the others") {
  // A plate of slivers that meet in its middle, which passes the hand there.
  std::vector<Vec3> corners{{}};
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const double angle = 2 * std::numbers::pi * i / 4000;
    corners.push_back({0.03 * std::cos(angle), 0.03 * std::sin(angle), 0});
    triangles.push_back({0, 1 + i, 1 + (i + 1) % 4000});
  }
  // Of four bodies one is the plate, one pushes, and the others move far away.
  const auto mesh = std::make_shared<const TriangleMesh>(corners, triangles);
  for (std::size_t plate = 0; plate < 4; ++plate)
    for (std::size_t pusher = 0; pusher < 4; ++pusher) {
      if (plate == pusher)
        continue;
      CAPTURE(plate);
      CAPTURE(pusher);
      SceneRig rig(1000);
      for (std::size_t i = 0; i < 4; ++i)
        if (i == plate)
          rig.add(MeshSurface{mesh}, {{0, 0, -0.01}, {}});
        else
          rig.add(Sphere{0.01}, {{-0.03, i == pusher ? 0 : 0.3, 0}, {}});
      rig.touch({0.01, 0.01, 0});
      for (std::size_t i = 0; i < 4; ++i)
        rig.glide(i,
                  i == plate ? Vec3{0.009, 0.009, 0.01} : Vec3{0.005, i == pusher ? 0.01 : 0.3, 0},
                  0.05);
      rig.rest(400, {10, 10, 0});
      CHECK(rig.model.proxy().x > 0.0149); // carried by the sphere
    }
}

TEST_CASE("without work for a single motion the known faces hold, at the full depth of the hand") {
  for (const double friction : {0.0, 0.4}) {
    SceneRig rig(84); // enough for a plane alone
    rig.add(Plane{}, {}, {500, 0, friction});
    rig.stroke({0, 0, 5}, {0, 0, -1});
    REQUIRE(rig.model.complete());
    for (int i = 0; i < 71; ++i) // more bodies close by than one motion can be tested against
      rig.add(Sphere{0.004}, {{0.0001 * i, 0.006, 0.005}, {}});
    int incomplete = 0;
    for (int n = 1; n <= 200; ++n) {
      const double depth = 1 + 0.01 * n, aside = 0.001 * n;
      const double held = friction > 0 ? 0.5 * aside : 0;
      CHECK(norm(rig.touch({aside, 0, -depth}) - Vec3{-held, 0, 0.5 * depth}) < 1e-9);
      incomplete += !rig.model.complete();
    }
    CHECK((friction > 0 ? incomplete == 0 : incomplete > 100)); // what sticks needs no search
    // To the side there is no more drag than friction allows, and no release is told.
    for (int n = 0; n <= 100; ++n) {
      const Vec3 force = rig.touch({0.1 * n, 0, -2});
      CHECK(force.z == doctest::Approx(1).epsilon(1e-9));
      CHECK(std::hypot(force.x, force.y) <= friction * force.z + 1e-9);
    }
    CHECK(!rig.model.complete());
    CHECK(norm(rig.touch({0, 0, 1})) < 1e-9); // away from the face nothing pulls
    CHECK(rig.count<ReleaseEvent>() == 0);
  }
}

TEST_CASE("the work limit does not touch a fast hand in a scene of 16 bodies and a mesh") {
  SceneRig limited, unlimited(WorkLimit::kUnlimited);
  for (auto* rig : {&limited, &unlimited}) {
    tactus::Random random(6);
    for (int i = 0; i < 16; ++i)
      rig->add(i % 2 ? Shape(Sphere{0.008}) : Shape(Box{{0.01, 0.004, 0.006}}),
               random_pose(random, 0.04), {500, 1, 0.5});
    rig->add(test::mesh_sphere(0.03, 159, 158), {{0.02, 0, 0}, {}}, {500, 1, 0.5});
  }
  tactus::Random random(7);
  Vec3 at{0, 200, 0}, aim = at;
  for (int n = 0; n < 1500; ++n) {
    if (n % 50 == 0)
      aim = random_point(random, 50);
    at += limited.ticks > 0 ? tactus::limited(aim - at, 2) : Vec3{}; // 2 m/s
    REQUIRE(limited.touch(at) == unlimited.touch(at));
    REQUIRE(limited.model.complete());
  }
}

TEST_CASE("for any work limit friction stays within its cone") {
  // The last round that was complete counts: a proxy on its way would drag by all that is missing.
  constexpr double kFriction = 0.5;
  const auto sheet = test::flat_mesh(40, 0.05);
  int completed = 0, cut = 0;
  for (std::int64_t work = 40; work < 3000; work += 20) {
    SceneRig rig(work);
    rig.add(sheet, {}, {500, 0, kFriction});
    rig.touch({-15, -9, 2});
    for (int n = 0; n < 60; ++n) {
      const double turn = 0.7 * n;
      const Vec3 force = rig.touch({15 * std::cos(turn), 9 * std::sin(2 * turn), -1 - 0.03 * n});
      (rig.model.complete() ? completed : cut) += 1;
      REQUIRE(std::hypot(force.x, force.y) <= kFriction * std::abs(force.z) + 1e-9);
    }
  }
  CHECK(completed > 500);
  CHECK(cut > 300);
}

TEST_CASE("for any work limit the proxy follows a rounded body without passing another") {
  for (std::int64_t work = 10; work < 600; work += 3) {
    SceneRig rig(work);
    rig.add(Sphere{0.02});
    rig.add(Box{{1e-4, 0.03, 0.03}}); // a wall through its middle
    rig.stroke({-10, 25, 0}, {-8, 18, 0});
    rig.rest(20, {-8, 18, 0});
    for (int n = 0; n < 20; ++n) {
      rig.touch({0.5, 0.2, 0}); // nearest on the sphere: beyond the wall
      REQUIRE(rig.model.proxy().x < 0);
    }
  }
}

TEST_CASE("for any work limit a hand deep in a mesh is pushed out at every tick") {
  const auto ball = test::mesh_sphere(0.02, 48, 48);
  for (std::int64_t work = 500; work < 2000; work += 60) {
    SceneRig rig(work);
    rig.add(ball);
    rig.stroke({0, 0, 22}, {0, 0, 15});
    rig.rest(100, {0, 0, 15});
    for (int n = 0; n < 100; ++n) {
      const double turn = 0.11 * n;
      REQUIRE(norm(rig.touch({15 * std::sin(turn), 0, 15 * std::cos(turn)})) > 0.5 * 500 * 5e-3);
    }
  }
}

TEST_CASE("without work no body counts as far away") {
  WorkLimit none(0), enough;
  const Vec3 far{0.019, 0.019, 0.019}; // but within the box around it
  const Shape ball = test::mesh_sphere(0.02, 48, 48);
  CHECK(is_farther(ball, far, 2e-4, enough));
  CHECK(!is_farther(ball, far, 2e-4, none));
}

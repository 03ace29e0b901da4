#include "core/dsp/random.hpp"
#include "core/haptic/scene/shape.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

// Where a tool that overlaps a solid leaves it. A convex solid is the intersection of half spaces
// n . p <= h(n), and the sum of it and a ball of radius R that of n . p <= h(n) + R: from a point p
// in it the way out is the least h(n) + R - n . p over all directions n, along that n.

using namespace tactus::haptic;
using tactus::Vec3;

namespace {

double support(const Box& box, const Vec3& n) {
  return box.half.x * std::abs(n.x) + box.half.y * std::abs(n.y) + box.half.z * std::abs(n.z);
}
double support(const Disk& disk, const Vec3& n) {
  return disk.radius * std::hypot(n.x, n.y) + disk.half_thickness * std::abs(n.z);
}
double support(const Sphere& sphere, const Vec3& n) { return sphere.radius * norm(n); }

/// Over the directions of faces, of edges (along an axis' planes and those through p) and of
/// corners (a Fibonacci lattice): every kind lies within 3 degrees of one of its own.
template <class Solid> double depth(const Solid& solid, const Vec3& p, double tool_radius) {
  double least = std::numeric_limits<double>::infinity();
  const auto look = [&](const Vec3& n) {
    least = std::min(least, support(solid, n) + tool_radius - dot(n, p));
  };
  const double r = std::hypot(p.x, p.y);
  for (int i = 0; i < 720; ++i) {
    const double a = 2 * std::numbers::pi * i / 720, c = std::cos(a), s = std::sin(a);
    for (const Vec3& n :
         {Vec3{c, s, 0}, Vec3{0, c, s}, Vec3{s, 0, c}, Vec3{c * p.x / r, c * p.y / r, s}})
      look(n);
  }
  look(p * (1 / norm(p)));
  for (int i = 0; i < 2000; ++i) {
    const double z = 1 - (i + 0.5) / 1000, across = std::sqrt(1 - z * z), a = 2.399963229728653 * i;
    look({across * std::cos(a), across * std::sin(a), z});
  }
  return least;
}

template <class Solid> void check(const Solid& solid, const Vec3& reach) {
  tactus::Random random(17);
  for (const double tool_radius : {0.0, 1e-3, 8e-3}) {
    int tested = 0, left = 0;
    for (int n = 0; n < 60; ++n) {
      Vec3 p;
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = (reach[axis] + tool_radius) * (2.4 * random.uniform() - 1.2);
      const double deep = depth(solid, p, tool_radius);
      WorkLimit work;
      const auto exit = nearest_exit(solid, tool_radius, p, work);
      CAPTURE(tool_radius);
      if (deep > 1e-4)
        REQUIRE(exit);
      if (deep < 0)
        CHECK_FALSE(exit);
      tested += deep > 1e-4;
      left += deep < 0;
      if (!exit)
        continue;
      const double out = norm(exit->point - p);
      CHECK(out <= deep + 1e-9);
      CHECK(out >= deep - 2e-3 * (norm(reach) + tool_radius));
      CHECK(norm(exit->normal) == doctest::Approx(1).epsilon(1e-9));
      CHECK(norm(exit->point - p - exit->normal * out) < 1e-9);
      // It lies on the surface: no direction has it outside, and its own normal touches it.
      CHECK(support(solid, exit->normal) + tool_radius - dot(exit->normal, exit->point) < 1e-9);
      CHECK(depth(solid, exit->point, tool_radius) > -1e-9);
    }
    CHECK(tested > 10);
    CHECK(left > 10);
  }
}

} // namespace

TEST_CASE("a tool leaves a solid by the shortest exit") {
  check(Box{{0.03, 0.01, 0.02}}, {0.03, 0.01, 0.02});
  check(Disk{0.03, 0.008}, {0.03, 0.03, 0.008});
  check(Disk{0.01, 0.03}, {0.01, 0.01, 0.03});
  check(Sphere{0.02}, {0.02, 0.02, 0.02});
}

TEST_CASE("a tool whose centre lies on a face, in a solid's middle or under a plane leaves it") {
  WorkLimit work;
  const Box box{{0.03, 0.01, 0.02}};
  const auto face = nearest_exit(box, 4e-3, {0.03, 0.002, -0.003}, work);
  REQUIRE(face);
  CHECK(norm(face->point - Vec3{0.034, 0.002, -0.003}) < 1e-12);
  CHECK(face->normal == Vec3{1, 0, 0});
  const auto rim = nearest_exit(Disk{0.03, 0.02}, 4e-3, {-0.03, 0, 0.001}, work);
  REQUIRE(rim);
  CHECK(norm(rim->point - Vec3{-0.034, 0, 0.001}) < 1e-12);
  const auto middle = nearest_exit(Sphere{0.02}, 4e-3, {}, work);
  REQUIRE(middle);
  CHECK(norm(middle->point) == doctest::Approx(0.024).scale(0));
  CHECK(norm(middle->point - middle->normal * 0.024) < 1e-15);
  const auto plane = nearest_exit(Plane{}, 4e-3, {0.01, -0.02, -0.05}, work);
  REQUIRE(plane);
  CHECK(norm(plane->point - Vec3{0.01, -0.02, 0.004}) < 1e-15);
  CHECK(plane->normal == Vec3{0, 0, 1});
  CHECK_FALSE(nearest_exit(Plane{}, 4e-3, {0, 0, 0.0041}, work));
}

TEST_CASE("round an edge, a corner or a rim a tool stays on the rounding that it touches") {
  // Its centre lies at R from the solid's nearest point: exactly, where the face goes on there.
  const double radius = 4e-3;
  const Box box{{0.03, 0.01, 0.02}};
  const auto check_rounding = [radius](const auto& solid, const Vec3& normal, const Vec3& nearest,
                                       const Vec3& gap) {
    const auto found = nearest_on_curve(solid, radius, normal * (1 / norm(normal)), nearest + gap);
    REQUIRE(found);
    CHECK(norm(found->normal - gap * (1 / norm(gap))) < 1e-12);
    CHECK(norm(found->point - nearest - found->normal * radius) < 1e-12);
  };
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) {
      const Vec3 edge_x{0.005, 0.01 * x, 0.02 * y}, edge_z{0.03 * x, 0.01 * y, -0.003};
      check_rounding(box, {x, y, 0}, edge_z, {1e-3 * x, 2e-3 * y, 0});
      check_rounding(box, {0, x, y}, edge_x, {0, 1e-4 * x, 2e-3 * y});
      check_rounding(box, {x, y, 1}, {0.03 * x, 0.01 * y, 0.02}, {1e-3 * x, 2e-3 * y, 1e-3});
      check_rounding(box, {x, y, -1}, {0.03 * x, 0.01 * y, -0.02}, {2e-3 * x, 1e-3 * y, -1e-3});
    }
  const Vec3 beside{0.031, 0.012, 0.005}; // an edge at x > 0, y > 0
  CHECK_FALSE(nearest_on_curve(box, radius, Vec3{-1, 1, 0} * std::sqrt(0.5), beside));
  CHECK_FALSE(nearest_on_curve(box, radius, {1, 0, 0}, {0.031, 0.002, 0.005})); // flat
  CHECK_FALSE(nearest_on_curve(box, radius, Vec3{1, 1, 0} * std::sqrt(0.5), {0.034, 0.013, 0}));
  CHECK_FALSE(nearest_on_curve(box, 0, Vec3{1, 1, 0} * std::sqrt(0.5), beside));

  const Disk disk{0.03, 0.01};
  for (const double z : {-1.0, 1.0}) {
    const Vec3 rim{0.018, 0.024, 0.01 * z}, gap{0.6e-3, 0.8e-3, 2e-3 * z};
    check_rounding(disk, {0.6, 0.8, z}, rim, gap);
    CHECK_FALSE(nearest_on_curve(disk, radius, Vec3{0.6, 0.8, -z} * std::sqrt(0.5), rim + gap));
    CHECK_FALSE(nearest_on_curve(disk, radius, {0, 0, z}, {0.01, 0, 0.011 * z})); // a face
  }
  check_rounding(disk, {0.6, 0.8, 0}, {0.018, 0.024, 0.002}, {0.6e-3, 0.8e-3, 0});
  const auto ball = nearest_on_curve(Sphere{0.02}, radius, {0, 0, 1}, {0, 0.003, 0.004});
  REQUIRE(ball);
  CHECK(norm(ball->point - Vec3{0, 0.0144, 0.0192}) < 1e-15);
}

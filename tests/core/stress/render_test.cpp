#include "core/stress/render.hpp"
#include "tests/approx.hpp"

using namespace tactus;
using haptic::Vec3;
using test::approx;

TEST_CASE("gamma sets the stiffness of a spring to the anchor") {
  const stress::RenderGains gains{0, 400, 0, 4};
  const Vec3 force = stress::spring_force(gains, Vec3{1, 1, 1} * 0.5, {3e-3, 0, 0});
  CHECK(force.x == approx(-0.6));
  CHECK(force.y == 0);
  CHECK(stress::spring_force({100, 400, 0, 0}, {}, {1e-3, 0, 0}).x == approx(-0.1));
}

TEST_CASE("gamma sets the viscosity of a damper") {
  const stress::RenderGains gains{0, 400, 0, 4};
  CHECK(stress::damper_force(gains, Vec3{1, 1, 1} * 0.25, {0, 0, 0.1}).z == approx(-0.1));
}

TEST_CASE("each axis has its own gamma, within 0 and 1") {
  const stress::RenderGains gains{100, 300, 1, 3};
  const Vec3 force = stress::spring_force(gains, {-5, 0.5, 7}, {1e-3, 1e-3, 1e-3});
  CHECK(force.x == approx(-0.1));
  CHECK(force.y == approx(-0.2));
  CHECK(force.z == approx(-0.3));
}

TEST_CASE("a damper takes energy and a spring gives back what it took") {
  const stress::RenderGains gains{50, 300, 1, 3};
  const Vec3 gamma{0.2, 0.9, 0.4}, motion{0.3, -0.7, 0.1};
  CHECK(dot(stress::damper_force(gains, gamma, motion), motion) < 0);
  const Vec3 there = stress::spring_force(gains, gamma, motion);
  CHECK(norm(there + stress::spring_force(gains, gamma, -motion)) == 0);
}

#include "core/stress/render.hpp"

#include <doctest/doctest.h>

using namespace tactus;

TEST_CASE("gamma sets stiffness and viscosity on each axis, within 0 and 1; both oppose") {
  const stress::RenderGains gains{100, 300, 1, 3};
  const Vec3 gamma{-5, 0.25, 7}, motion{1e-3, -2e-3, 3e-3};
  CHECK(norm(stress::spring_force(gains, gamma, motion) - Vec3{-0.1, 0.3, -0.9}) < 1e-15);
  CHECK(norm(stress::damper_force(gains, gamma, motion) - Vec3{-1e-3, 3e-3, -9e-3}) < 1e-15);
}

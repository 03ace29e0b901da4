#include "tests/core/dsp/simd_checks.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

namespace tactus::simd {
namespace {

TEST_CASE("every lane computes the same bits as a scalar") {
  SUBCASE("one double") { check_against_scalars<double>(); }
  SUBCASE("doubles") { check_against_scalars<Lanes<double, 6>>(); }
  SUBCASE("floats") { check_against_scalars<Lanes<float, 8>>(); }
}

TEST_CASE("one lane is enough for any, and is the one bit") {
  SUBCASE("one double") { check_single_lanes<double>(); }
  SUBCASE("doubles") { check_single_lanes<Lanes<double, 8>>(); }
  SUBCASE("floats") { check_single_lanes<Lanes<float, 16>>(); }
}

TEST_CASE("of two numbers of which one is none, minimum and maximum take the first") {
  // As C++'s (b < a ? b : a): nothing compares less than what is no number.
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using V = Lanes<double, 2>;
  CHECK(minimum(3.0, nan) == 3.0);
  CHECK(maximum(3.0, nan) == 3.0);
  CHECK(std::isnan(minimum(nan, 3.0)));
  CHECK(lane(minimum(V(3.0), V(nan)), 1) == 3.0);
  CHECK(std::isnan(lane(maximum(V(nan), V(3.0)), 0)));
}

TEST_CASE("a comparison with no number is false in its lane alone") {
  Lanes<double, 4> x(1.0);
  set_lane(x, 2, std::numeric_limits<double>::quiet_NaN());
  const auto mask = x > Lanes<double, 4>(0.0);
  CHECK(lane(mask, 1));
  CHECK_FALSE(lane(mask, 2));
}

} // namespace
} // namespace tactus::simd

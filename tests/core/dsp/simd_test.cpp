#include "core/dsp/simd.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace tactus::simd {
namespace {

template <class T> bool same_bits(T a, T b) { return std::memcmp(&a, &b, sizeof(T)) == 0; }

template <class V> void check_against_scalars() {
  using T = typename LaneTraits<V>::Scalar;
  constexpr int kLanes = LaneTraits<V>::count;
  std::mt19937 random(3);
  std::uniform_real_distribution<T> values(-10, 10);
  for (int trial = 0; trial < 200; ++trial) {
    V a(0.0), b(0.0);
    for (int i = 0; i < kLanes; ++i) {
      set_lane(a, i, trial == 0 ? T(0) : trial == 1 ? T(-0.0) : values(random));
      set_lane(b, i, values(random));
    }
    for (int i = 0; i < kLanes; ++i) {
      const T x = lane(a, i), y = lane(b, i);
      CHECK(same_bits(lane(a + b, i), x + y));
      CHECK(same_bits(lane(a - b, i), x - y));
      CHECK(same_bits(lane(a * b + a, i), x * y + x));
      CHECK(same_bits(lane(a / b, i), x / y));
      CHECK(same_bits(lane(-a, i), -x));
      CHECK(same_bits(lane(absolute(a), i), std::abs(x)));
      CHECK(same_bits(lane(copy_sign(a, b), i), std::copysign(x, y)));
      CHECK(same_bits(lane(square_root(absolute(a)), i), std::sqrt(std::abs(x))));
      CHECK(same_bits(lane(select(a < b, a, b), i), x < y ? x : y));
      CHECK(same_bits(lane(minimum(a, b), i), minimum(x, y)));
      CHECK(same_bits(lane(maximum(a, b), i), maximum(x, y)));
      CHECK(lane((a < b) | (a > V(5.0)), i) == (x < y || x > T(5)));
      CHECK(lane((!(a <= b)) & (b >= V(0.0)), i) == (!(x <= y) && y >= T(0)));
      CHECK_FALSE(lane(a < a, i));
      CHECK(lane((a <= a) & (a >= a), i));
      V sum = a, difference = a, product = a;
      sum += b, difference -= b, product *= b;
      CHECK(same_bits(lane(sum, i), x + y));
      CHECK(same_bits(lane(difference, i), x - y));
      CHECK(same_bits(lane(product, i), x * y));
      CHECK((bits(a < b) >> i & 1u) == (x < y ? 1u : 0u));
    }
  }
}

TEST_CASE("every lane computes the same bits as a scalar") {
  SUBCASE("one double") { check_against_scalars<double>(); }
  SUBCASE("doubles") { check_against_scalars<Lanes<double, 6>>(); }
  SUBCASE("floats") { check_against_scalars<Lanes<float, 8>>(); }
}

template <class V> void check_single_lanes() {
  using T = typename LaneTraits<V>::Scalar;
  CHECK(bits(V(0.0) > V(0.5)) == 0);
  for (int i = 0; i < LaneTraits<V>::count; ++i) {
    V x(0.0);
    set_lane(x, i, T(1));
    CHECK(any(x > V(0.5)));
    CHECK_FALSE(any(x > V(1.5)));
    CHECK(bits(x > V(0.5)) == 1u << i);
    CHECK(any(!(x > V(0.5))) == (LaneTraits<V>::count > 1));
    for (int k = 0; k < LaneTraits<V>::count; ++k)
      CHECK(lane(x, k) == (k == i ? T(1) : T(0)));
  }
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

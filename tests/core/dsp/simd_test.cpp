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
    }
  }
}

TEST_CASE("every lane computes the same bits as a scalar") {
  SUBCASE("one double") { check_against_scalars<double>(); }
  SUBCASE("doubles") { check_against_scalars<Lanes<double, 6>>(); }
  SUBCASE("floats") { check_against_scalars<Lanes<float, 8>>(); }
}

TEST_CASE("one lane is enough for any") {
  using V = Lanes<double, 8>;
  for (int i = 0; i < 8; ++i) {
    V x(0.0);
    set_lane(x, i, 1.0);
    CHECK(any(x > V(0.5)));
    CHECK_FALSE(any(x > V(1.5)));
  }
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

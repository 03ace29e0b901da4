#pragma once

#include "core/dsp/simd.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <random>

/// What holds for lanes of any type, number and instruction set.
namespace tactus::simd {

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
      CHECK_FALSE(lane(a > a, i));
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

} // namespace tactus::simd

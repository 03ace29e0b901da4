#include "tests/core/dsp/simd_checks.hpp"

#include <doctest/doctest.h>

// The same for the registers of 32 bytes; this program is compiled for AVX2.

namespace tactus::simd {
namespace {

bool absent() { return !__builtin_cpu_supports("avx2"); }

TEST_CASE("every lane of AVX2 computes the same bits as a scalar" * doctest::skip(absent())) {
  SUBCASE("doubles") { check_against_scalars<Lanes<double, 12, Avx2>>(); }
  SUBCASE("floats") { check_against_scalars<Lanes<float, 16, Avx2>>(); }
  SUBCASE("doubles beside AVX-512") { check_against_scalars<Lanes<double, 8, Avx512>>(); }
}

TEST_CASE("one lane of AVX2 is enough for any, and is the one bit" * doctest::skip(absent())) {
  SUBCASE("doubles") { check_single_lanes<Lanes<double, 12, Avx2>>(); }
  SUBCASE("floats") { check_single_lanes<Lanes<float, 24, Avx2>>(); }
}

} // namespace
} // namespace tactus::simd

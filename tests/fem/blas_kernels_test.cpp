#include "fem/blas_kernels.hpp"

#include <doctest/doctest.h>

using namespace tactus::fem;
namespace simd = tactus::simd;

TEST_CASE("kernels of 2004 are replaced where the processor can do more, others stay") {
  CHECK(faster_blas_kernels("Prescott", simd::VectorSet::kAvx512) == "SkylakeX");
  CHECK(faster_blas_kernels("Prescott", simd::VectorSet::kAvx2) == "Haswell");
  CHECK(faster_blas_kernels("Prescott", simd::VectorSet::kBaseline).empty());
  for (const char* chosen : {"Haswell", "SkylakeX", "SapphireRapids", "Zen", "Nehalem"})
    CHECK(faster_blas_kernels(chosen, simd::VectorSet::kAvx512).empty());
}

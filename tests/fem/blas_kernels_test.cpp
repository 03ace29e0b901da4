#include "fem/blas_kernels.hpp"

#include <doctest/doctest.h>

using namespace tactus::fem;

TEST_CASE("kernels of 2004 are replaced where the processor can do more, others stay") {
  CHECK(faster_blas_kernels("Prescott", {.avx2 = true, .avx512 = true}) == "SkylakeX");
  CHECK(faster_blas_kernels("Prescott", {.avx2 = true, .avx512 = false}) == "Haswell");
  CHECK(faster_blas_kernels("Prescott", {}).empty());
  for (const char* chosen : {"Haswell", "SkylakeX", "SapphireRapids", "Zen", "Nehalem"})
    CHECK(faster_blas_kernels(chosen, {.avx2 = true, .avx512 = true}).empty());
}

#include "fem/blas_kernels.hpp"

#include <cblas.h>

#include <array>
#include <climits>
#include <cstdlib>

#include <unistd.h>

namespace tactus::fem {
namespace {

constexpr const char* kVariable = "OPENBLAS_CORETYPE";

simd::VectorSet widest() noexcept {
  for (const auto set : {simd::VectorSet::kAvx512, simd::VectorSet::kAvx2})
    if (simd::runs(set))
      return set;
  return simd::VectorSet::kBaseline;
}

} // namespace

std::string_view faster_blas_kernels(std::string_view in_use, simd::VectorSet widest) noexcept {
  if (in_use != "Prescott" || widest == simd::VectorSet::kBaseline)
    return {};
  return widest == simd::VectorSet::kAvx512 ? "SkylakeX" : "Haswell";
}

void restart_with_faster_blas_kernels(char** words) noexcept {
  if (std::getenv(kVariable))
    return;
  const std::string_view faster = faster_blas_kernels(openblas_get_corename(), widest());
  // Uses the program's real path: if it were started as /proc/self/exe, the process would be named
  // "exe".
  std::array<char, PATH_MAX> path{};
  if (faster.empty() || ::readlink("/proc/self/exe", path.data(), path.size() - 1) < 0 ||
      ::setenv(kVariable, faster.data(), 1) != 0)
    return;
  ::execv(path.data(), words); // returns only on failure; the current kernels are then used
}

} // namespace tactus::fem

#include "fem/blas_kernels.hpp"

#include <cblas.h>

#include <array>
#include <climits>
#include <cstdlib>

#include <unistd.h>

namespace tactus::fem {
namespace {

constexpr const char* kVariable = "OPENBLAS_CORETYPE";

VectorUnits vector_units() noexcept {
#if defined(__x86_64__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") &&
                      __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") &&
                      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  return {avx2, avx512};
#else
  return {};
#endif
}

} // namespace

std::string_view faster_blas_kernels(std::string_view in_use, VectorUnits units) noexcept {
  if (in_use != "Prescott" || !units.avx2)
    return {};
  return units.avx512 ? "SkylakeX" : "Haswell";
}

void restart_with_faster_blas_kernels(char** words) noexcept {
  if (std::getenv(kVariable))
    return;
  const std::string_view faster = faster_blas_kernels(openblas_get_corename(), vector_units());
  // By its path: started as /proc/self/exe, the process would be called "exe".
  std::array<char, PATH_MAX> path{};
  if (faster.empty() || ::readlink("/proc/self/exe", path.data(), path.size() - 1) < 0 ||
      ::setenv(kVariable, faster.data(), 1) != 0)
    return;
  ::execv(path.data(), words); // returns only when it fails: then with the kernels at hand
}

} // namespace tactus::fem

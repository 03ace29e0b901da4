#include "core/dsp/vector_set.hpp"

namespace tactus::simd {

bool runs(VectorSet set) noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_cpu_init();
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  switch (set) {
  case VectorSet::kAvx512: // the extensions that all of Intel's and AMD's processors with 512 bits
                           // share
    return avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
  case VectorSet::kAvx2:
    return avx2;
  case VectorSet::kBaseline:
    break;
  }
#endif
  return set == VectorSet::kBaseline;
}

} // namespace tactus::simd

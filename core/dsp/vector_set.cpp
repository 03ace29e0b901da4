#include "core/dsp/vector_set.hpp"

#include <cstdint>

namespace tactus::simd {

#if defined(__APPLE__) && defined(__x86_64__)
// libSystem does not have what __builtin_cpu_supports() reads. Intel, "Software Developer's
// Manual", volume 1, section 14.7.1: leaf 1 tells of fused operations (ECX 12) and that the system
// saves registers as XCR0 tells (ECX 27), here those of 256 bits; leaf 7 tells of AVX2 (EBX 5).
// macOS saves those of 512 bits from their first use on, so that XCR0 does not tell of them: they
// stay unused.
bool runs(VectorSet set) noexcept {
  const auto cpuid = [](std::uint32_t leaf, std::uint32_t& b, std::uint32_t& c) {
    std::uint32_t a = leaf, d = 0;
    c = 0;
    __asm__("cpuid" : "+a"(a), "=b"(b), "+c"(c), "=d"(d));
  };
  std::uint32_t low = 0, high = 0, b1 = 0, c1 = 0, b7 = 0, c7 = 0;
  cpuid(1, b1, c1);
  cpuid(7, b7, c7); // every processor of macOS 11 has this leaf
  constexpr std::uint32_t kFusedAndSaved = (1U << 12) | (1U << 27), kAvx2 = 1U << 5;
  if ((c1 & kFusedAndSaved) != kFusedAndSaved || (b7 & kAvx2) == 0)
    return set == VectorSet::kBaseline;
  __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return set <= ((low & 6) == 6 ? VectorSet::kAvx2 : VectorSet::kBaseline);
}
#else
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
#endif

} // namespace tactus::simd

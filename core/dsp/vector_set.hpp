#pragma once

namespace tactus::simd {

/// The instruction sets that kernels are compiled for, the narrowest first.
enum class VectorSet { kBaseline, kAvx2, kAvx512 };
inline constexpr VectorSet kWidest = VectorSet::kAvx512;

/// True if this processor runs code that is compiled for the set.
[[nodiscard]] bool runs(VectorSet) noexcept;

// The sets as types. The set is part of every vector type, so the linker cannot use code compiled
// for one set in place of code for another. Each set has source files of its own, with its own
// compiler flags.
struct Baseline {
  static constexpr VectorSet kSet = VectorSet::kBaseline;
  static constexpr int register_bytes = 16;
};
struct Avx2 {
  static constexpr VectorSet kSet = VectorSet::kAvx2;
  static constexpr int register_bytes = 32;
};
/// AVX-512's masks and 32 registers, with vectors of 256 bits.
struct Avx512 {
  static constexpr VectorSet kSet = VectorSet::kAvx512;
  static constexpr int register_bytes = 32;
};

/// Returns make(set) for the first set of `Sets` that this processor runs and that is no wider than
/// `widest`; else make(Baseline{}). `Sets` begin with the widest. Only x86 has source files for
/// sets other than Baseline.
template <class... Sets, class Make>
[[nodiscard]] auto dispatch([[maybe_unused]] VectorSet widest, const Make& make) {
#if defined(__x86_64__) || defined(__i386__)
  decltype(make(Baseline{})) made{};
  if (((Sets::kSet <= widest && runs(Sets::kSet) && (made = make(Sets{}), true)) || ...))
    return made;
#endif
  return make(Baseline{});
}

} // namespace tactus::simd

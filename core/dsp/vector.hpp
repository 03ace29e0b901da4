#pragma once

#include "core/dsp/simd.hpp"

#include <cstddef>

namespace tactus::simd {

/// Size of the widest vectors of a set, bytes.
template <class Set> inline constexpr std::size_t kVectorBytes = Set::register_bytes;
template <> inline constexpr std::size_t kVectorBytes<Avx512> = 64;

/// Vector operations on aligned arrays, in groups of `group` numbers. The kernels of contact, modal
/// and stress use them. The set is a template parameter, so the linker cannot use code for a newer
/// processor in place of code for an older one.
template <class Set, class T, std::size_t group> struct Vectors {
  using V [[gnu::vector_size(kVectorBytes<Set>), gnu::may_alias]] = T;
  static constexpr std::size_t kWidth = sizeof(V) / sizeof(T);
  static constexpr std::size_t kRegisters = group / kWidth; ///< registers of a group

  [[gnu::always_inline]] static V load(const T* from) noexcept {
    return *reinterpret_cast<const V*>(from);
  }
  [[gnu::always_inline]] static void store(T* to, V value) noexcept {
    *reinterpret_cast<V*>(to) = value;
  }
  [[gnu::always_inline]] static V all(double value) noexcept { return static_cast<T>(value) - V{}; }
  /// a b + c; with a single rounding if the file is compiled for fused operations.
  [[gnu::always_inline]] static V multiply_add(V a, V b, V c) noexcept {
#if defined(__AVX512F__)
    if constexpr (sizeof(V) == 64) {
      if constexpr (sizeof(T) == 8)
        return _mm512_fmadd_pd(a, b, c);
      else
        return _mm512_fmadd_ps(a, b, c);
    }
#endif
#if defined(__AVX2__) && defined(__FMA__)
    if constexpr (sizeof(V) == 32) {
      if constexpr (sizeof(T) == 8)
        return _mm256_fmadd_pd(a, b, c);
      else
        return _mm256_fmadd_ps(a, b, c);
    }
#endif
    return a * b + c;
  }
  /// Sum over a group's registers and lanes. The upper half is added to the lower until one number
  /// is left, so the order is the same for every width.
  [[gnu::always_inline]] static T across(const V* sums) noexcept {
    V partial[kRegisters];
#pragma GCC unroll 8
    for (std::size_t r = 0; r < kRegisters; ++r)
      partial[r] = sums[r];
#pragma GCC unroll 4
    for (std::size_t count = kRegisters / 2; count > 0; count /= 2)
#pragma GCC unroll 8
      for (std::size_t r = 0; r < count; ++r)
        partial[r] += partial[r + count];
    return halves(partial[0]);
  }

private:
  template <class W> [[gnu::always_inline]] static T halves(W sum) noexcept {
    constexpr std::size_t kCount = sizeof(W) / sizeof(T);
    if constexpr (kCount == 16)
      return halves(__builtin_shufflevector(sum, sum, 0, 1, 2, 3, 4, 5, 6, 7) +
                    __builtin_shufflevector(sum, sum, 8, 9, 10, 11, 12, 13, 14, 15));
    else if constexpr (kCount == 8)
      return halves(__builtin_shufflevector(sum, sum, 0, 1, 2, 3) +
                    __builtin_shufflevector(sum, sum, 4, 5, 6, 7));
    else if constexpr (kCount == 4)
      return halves(__builtin_shufflevector(sum, sum, 0, 1) +
                    __builtin_shufflevector(sum, sum, 2, 3));
    else
      return sum[0] + sum[1];
  }
};

} // namespace tactus::simd

#pragma once

#include "core/modal/bank/bank_kernel.hpp"

#include <cstddef>

/// The mode bank's two matrix products, in tiles that stay in registers: forces into states (sums
/// over times, one for each mode) and states into outputs (sums over modes, one for each sample).
///
/// A tile adds in the same order as single sums would, so that a time block gives the same bits
/// alone and together with others.
namespace tactus::modal {

template <class Set> struct BankVector;

template <> struct BankVector<simd::Baseline> {
  using Type [[gnu::vector_size(16)]] = float;
  static constexpr std::size_t width = 4, registers = 2, time_blocks = 2, times = 2;
  static Type multiply_add(Type a, Type b, Type c) noexcept { return a * b + c; }
};
#if defined(__AVX2__) && defined(__FMA__)
template <> struct BankVector<simd::Avx2> {
  using Type [[gnu::vector_size(32)]] = float;
  static constexpr std::size_t width = 8, registers = 2, time_blocks = 2, times = 2;
  [[gnu::always_inline]] static Type multiply_add(Type a, Type b, Type c) noexcept {
    return _mm256_fmadd_ps(a, b, c);
  }
};
#endif
#if defined(__AVX512F__)
template <> struct BankVector<simd::Avx512> {
  using Type [[gnu::vector_size(64)]] = float;
  static constexpr std::size_t width = 16, registers = 2, time_blocks = 4, times = 4;
  [[gnu::always_inline]] static Type multiply_add(Type a, Type b, Type c) noexcept {
    return _mm512_fmadd_ps(a, b, c);
  }
};
#endif

/// States of up to kMaxBlocks blocks at each time block of a chunk, real and imaginary parts apart.
struct alignas(64) TimeBlockPlanes {
  static constexpr std::size_t kMaxBlocks = 2;
  Lane real[kMaxTimeBlocks][kMaxBlocks], imaginary[kMaxTimeBlocks][kMaxBlocks];
};

template <class Set> struct BankTiles {
  using Traits = BankVector<Set>;
  using V = typename Traits::Type;
  static constexpr std::size_t kWidth = Traits::width;
  static constexpr std::size_t kRegisters = Traits::registers; ///< registers of modes in a tile of
                                                               ///< gather()
  static constexpr std::size_t kTimeBlocks = Traits::time_blocks; ///< time blocks in a tile of
                                                                  ///< gather()
  static constexpr std::size_t kTimes = Traits::times; ///< samples in a tile of add_output()
  static constexpr std::size_t kStep = kRegisters * kWidth;

  [[gnu::always_inline]] static V fma(V a, V b, V c) noexcept {
    return Traits::multiply_add(a, b, c);
  }
  [[gnu::always_inline]] static V load(const float* from) noexcept {
    return *reinterpret_cast<const V*>(from);
  }
  [[gnu::always_inline]] static V load(const Lane& lane, std::size_t at) noexcept {
    return load(lane.v + at);
  }
  [[gnu::always_inline]] static void store(Lane& lane, std::size_t at, V value) noexcept {
    *reinterpret_cast<V*>(lane.v + at) = value;
  }
  [[gnu::always_inline]] static V all(float x) noexcept { return x - V{}; }

  /// The complex sums of a tile of TimeBlocks time blocks and kRegisters registers of modes.
  template <std::size_t TimeBlocks> struct TileSum {
    V real[TimeBlocks][kRegisters], imaginary[TimeBlocks][kRegisters];
  };
  /// For each time block l, adds to `sum` the sum over m < count of Re(power(m)) x[l * stride + m]
  /// and Im(power(m)) y[l * stride + m].
  // Always inlined, so that the seven arguments stay in registers.
  template <std::size_t TimeBlocks, class Power>
  [[gnu::always_inline]] static void gather(const Power& power, std::size_t at, std::size_t count,
                                            const float* x, const float* y, std::size_t stride,
                                            TileSum<TimeBlocks>& sum) noexcept {
#pragma GCC unroll 1
    for (std::size_t m = 0; m < count; ++m) {
      const ComplexLane& p = power(m);
      V real[kRegisters], imaginary[kRegisters];
#pragma GCC unroll 4
      for (std::size_t r = 0; r < kRegisters; ++r) {
        real[r] = load(p.real, at + r * kWidth);
        imaginary[r] = load(p.imaginary, at + r * kWidth);
      }
#pragma GCC unroll 4
      for (std::size_t l = 0; l < TimeBlocks; ++l) {
        const V even = all(x[l * stride + m]), odd = all(y[l * stride + m]);
#pragma GCC unroll 4
        for (std::size_t r = 0; r < kRegisters; ++r) {
          sum.real[l][r] = fma(real[r], even, sum.real[l][r]);
          sum.imaginary[l][r] = fma(imaginary[r], odd, sum.imaginary[l][r]);
        }
      }
    }
  }

  /// sums[l * stride + i] += sum over the blocks' modes of part[b][i] c[l][b], for TimeBlocks time
  /// blocks and Times samples i; `from_zero`: `sums` is overwritten. `part` points to lanes of the
  /// poles' powers, one ComplexLane from power to power.
  template <std::size_t TimeBlocks, std::size_t Times>
  [[gnu::noinline]] static void add_output(const float* const* part, std::size_t blocks,
                                           const Lane (*c)[TimeBlockPlanes::kMaxBlocks], V* sums,
                                           std::size_t stride, bool from_zero) noexcept {
    constexpr std::size_t kLaneStride = sizeof(ComplexLane) / sizeof(float);
    constexpr std::size_t kTimeBlockStride = TimeBlockPlanes::kMaxBlocks * kLanes;
    V sum[TimeBlocks][Times];
#pragma GCC unroll 4
    for (std::size_t l = 0; l < TimeBlocks; ++l)
#pragma GCC unroll 4
      for (std::size_t i = 0; i < Times; ++i)
        sum[l][i] = from_zero ? V{} : sums[l * stride + i];
    for (std::size_t b = 0; b < blocks; ++b) {
      const float* p = part[b];
      const float* state = c[0][b].v;
      const float* const end = p + kLanes;
#pragma GCC unroll 1
      for (; p != end; p += kWidth, state += kWidth) {
        V z[TimeBlocks];
#pragma GCC unroll 4
        for (std::size_t l = 0; l < TimeBlocks; ++l)
          z[l] = load(state + l * kTimeBlockStride);
#pragma GCC unroll 4
        for (std::size_t i = 0; i < Times; ++i) {
          const V power = load(p + i * kLaneStride);
#pragma GCC unroll 4
          for (std::size_t l = 0; l < TimeBlocks; ++l)
            sum[l][i] = fma(power, z[l], sum[l][i]);
        }
      }
    }
#pragma GCC unroll 4
    for (std::size_t l = 0; l < TimeBlocks; ++l)
#pragma GCC unroll 4
      for (std::size_t i = 0; i < Times; ++i)
        sums[l * stride + i] = sum[l][i];
  }

  /// The sums over the lanes of each of kWidth vectors, as one vector. For two vectors at a time,
  /// the halves are added, then the quarters.
  [[gnu::always_inline]] static V across(const V* of) noexcept {
    if constexpr (kWidth == 16) {
      V half[8], quarter[4];
#pragma GCC unroll 8
      for (std::size_t i = 0; i < 8; ++i)
        half[i] = __builtin_shufflevector(of[i], of[i + 8], 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19,
                                          20, 21, 22, 23) +
                  __builtin_shufflevector(of[i], of[i + 8], 8, 9, 10, 11, 12, 13, 14, 15, 24, 25,
                                          26, 27, 28, 29, 30, 31);
#pragma GCC unroll 4
      for (std::size_t i = 0; i < 4; ++i)
        quarter[i] = __builtin_shufflevector(half[i], half[i + 4], 0, 1, 2, 3, 16, 17, 18, 19, 8, 9,
                                             10, 11, 24, 25, 26, 27) +
                     __builtin_shufflevector(half[i], half[i + 4], 4, 5, 6, 7, 20, 21, 22, 23, 12,
                                             13, 14, 15, 28, 29, 30, 31);
      return last_pairs(quarter);
    } else if constexpr (kWidth == 8) {
      V quarter[4];
#pragma GCC unroll 4
      for (std::size_t i = 0; i < 4; ++i)
        quarter[i] = __builtin_shufflevector(of[i], of[i + 4], 0, 1, 2, 3, 8, 9, 10, 11) +
                     __builtin_shufflevector(of[i], of[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
      return last_pairs(quarter);
    } else {
      return last_pairs(of);
    }
  }
  /// The sum over the lanes of one vector, in the same order.
  [[gnu::always_inline]] static float across(V sum) noexcept {
    using Four [[gnu::vector_size(16)]] = float;
    Four four;
    if constexpr (kWidth == 16) {
      const auto half = __builtin_shufflevector(sum, sum, 0, 1, 2, 3, 4, 5, 6, 7) +
                        __builtin_shufflevector(sum, sum, 8, 9, 10, 11, 12, 13, 14, 15);
      four = __builtin_shufflevector(half, half, 0, 1, 2, 3) +
             __builtin_shufflevector(half, half, 4, 5, 6, 7);
    } else if constexpr (kWidth == 8) {
      four = __builtin_shufflevector(sum, sum, 0, 1, 2, 3) +
             __builtin_shufflevector(sum, sum, 4, 5, 6, 7);
    } else {
      four = sum;
    }
    return (four[0] + four[2]) + (four[1] + four[3]);
  }

private:
  /// The last two additions: every four lanes belong to four sums by now.
  [[gnu::always_inline]] static V last_pairs(const V* of) noexcept {
    return firsts(twos(of[0], of[1]), twos(of[2], of[3]));
  }
  [[gnu::always_inline]] static V twos(V a, V b) noexcept {
    if constexpr (kWidth == 16)
      return __builtin_shufflevector(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28,
                                     29) +
             __builtin_shufflevector(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30,
                                     31);
    else if constexpr (kWidth == 8)
      return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13) +
             __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
    else
      return __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
  }
  [[gnu::always_inline]] static V firsts(V a, V b) noexcept {
    if constexpr (kWidth == 16)
      return __builtin_shufflevector(a, b, 0, 2, 16, 18, 4, 6, 20, 22, 8, 10, 24, 26, 12, 14, 28,
                                     30) +
             __builtin_shufflevector(a, b, 1, 3, 17, 19, 5, 7, 21, 23, 9, 11, 25, 27, 13, 15, 29,
                                     31);
    else if constexpr (kWidth == 8)
      return __builtin_shufflevector(a, b, 0, 2, 8, 10, 4, 6, 12, 14) +
             __builtin_shufflevector(a, b, 1, 3, 9, 11, 5, 7, 13, 15);
    else
      return __builtin_shufflevector(a, b, 0, 2, 4, 6) + __builtin_shufflevector(a, b, 1, 3, 5, 7);
  }
};

} // namespace tactus::modal

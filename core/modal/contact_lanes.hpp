#pragma once

#include "core/modal/contact_kernel.hpp"

#include <array>

/// A contact's loops over modes, written once for any instruction set; a template on the set, so
/// that the linker never takes a newer processor's code for an older one's.
namespace tactus::modal {

template <class Set> struct ContactVector;

template <> struct ContactVector<simd::Baseline> {
  using Type [[gnu::vector_size(16), gnu::may_alias]] = double;
  static Type multiply_add(Type a, Type b, Type c) noexcept { return a * b + c; }
};
#if defined(__AVX2__) && defined(__FMA__)
template <> struct ContactVector<simd::Avx2> {
  using Type [[gnu::vector_size(32), gnu::may_alias]] = double;
  [[gnu::always_inline]] static Type multiply_add(Type a, Type b, Type c) noexcept {
    return _mm256_fmadd_pd(a, b, c);
  }
};
#endif
#if defined(__AVX512F__)
template <> struct ContactVector<simd::Avx512> {
  using Type [[gnu::vector_size(64), gnu::may_alias]] = double;
  [[gnu::always_inline]] static Type multiply_add(Type a, Type b, Type c) noexcept {
    return _mm512_fmadd_pd(a, b, c);
  }
};
#endif

template <class Set> class ContactLanes final : public ContactKernel {
  using V = typename ContactVector<Set>::Type;
  static constexpr std::size_t kWidth = sizeof(V) / sizeof(double);
  static constexpr std::size_t kRegisters = kContactLanes / kWidth; // of a turn of the loop

  [[gnu::always_inline]] static V fma(V a, V b, V c) noexcept {
    return ContactVector<Set>::multiply_add(a, b, c);
  }
  [[gnu::always_inline]] static V load(const double* from) noexcept {
    return *reinterpret_cast<const V*>(from);
  }
  [[gnu::always_inline]] static void store(double* to, V value) noexcept {
    *reinterpret_cast<V*>(to) = value;
  }
  /// Sum of all lanes of all registers, halving in registers.
  [[gnu::always_inline]] static double across(const V* sums) noexcept {
    V part[kRegisters];
    for (std::size_t r = 0; r < kRegisters; ++r)
      part[r] = sums[r];
    for (std::size_t width = kRegisters / 2; width > 0; width /= 2)
      for (std::size_t r = 0; r < width; ++r)
        part[r] += part[r + width];
    const V all = part[0];
    if constexpr (kWidth == 8) {
      const auto four = __builtin_shufflevector(all, all, 0, 1, 2, 3) +
                        __builtin_shufflevector(all, all, 4, 5, 6, 7);
      const auto two =
          __builtin_shufflevector(four, four, 0, 1) + __builtin_shufflevector(four, four, 2, 3);
      return two[0] + two[1];
    } else if constexpr (kWidth == 4) {
      const auto two =
          __builtin_shufflevector(all, all, 0, 1) + __builtin_shufflevector(all, all, 2, 3);
      return two[0] + two[1];
    } else {
      return all[0] + all[1];
    }
  }

public:
  double turn(SplitView z, ConstSplitView p, const double* gain,
              std::size_t count) const noexcept override {
    V sums[kRegisters] = {};
    for (std::size_t k = 0; k < count; k += kContactLanes) {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r) {
        const std::size_t i = k + r * kWidth;
        const V re = load(z.real + i), im = load(z.imaginary + i);
        const V turn_re = load(p.real + i), turn_im = load(p.imaginary + i);
        store(z.real + i, fma(turn_re, re, -turn_im * im));
        const V turned = fma(turn_re, im, turn_im * re);
        store(z.imaginary + i, turned);
        sums[r] = fma(load(gain + i), turned, sums[r]);
      }
    }
    return across(sums);
  }

  void push(SplitView z, ConstSplitView b, double force,
            std::size_t count) const noexcept override {
    const V all = force - V{};
    for (std::size_t k = 0; k < count; k += kContactLanes) {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r) {
        const std::size_t i = k + r * kWidth;
        store(z.real + i, fma(load(b.real + i), all, load(z.real + i)));
        store(z.imaginary + i, fma(load(b.imaginary + i), all, load(z.imaginary + i)));
      }
    }
  }

  double sum(const double* a, const double* b, std::size_t count) const noexcept override {
    V sums[kRegisters] = {};
    for (std::size_t k = 0; k < count; k += kContactLanes) {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r)
        sums[r] = fma(load(a + k + r * kWidth), load(b + k + r * kWidth), sums[r]);
    }
    return across(sums);
  }

  double hear(ConstSplitView w, ConstSplitView z, std::size_t count) const noexcept override {
    V sums[kRegisters] = {}, others[kRegisters] = {};
    for (std::size_t k = 0; k < count; k += kContactLanes) {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r) {
        const std::size_t i = k + r * kWidth;
        sums[r] = fma(load(w.real + i), load(z.imaginary + i), sums[r]);
        others[r] = fma(load(w.imaginary + i), load(z.real + i), others[r]);
      }
    }
    for (std::size_t r = 0; r < kRegisters; ++r)
      sums[r] += others[r];
    return across(sums);
  }
};

} // namespace tactus::modal

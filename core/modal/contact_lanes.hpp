#pragma once

#include "core/modal/contact_kernel.hpp"

#include <type_traits>

/// A contact's loops over modes, written once for any instruction set and precision; a template on
/// the set, so that the linker never takes a newer processor's code for an older one's.
namespace tactus::modal {

template <class Set> struct ContactVector;

template <> struct ContactVector<simd::Baseline> {
  static constexpr std::size_t bytes = 16;
  template <class V> static V multiply_add(V a, V b, V c) noexcept { return a * b + c; }
};
#if defined(__AVX2__) && defined(__FMA__)
template <> struct ContactVector<simd::Avx2> {
  static constexpr std::size_t bytes = 32;
  template <class V> [[gnu::always_inline]] static V multiply_add(V a, V b, V c) noexcept {
    if constexpr (std::is_same_v<std::remove_reference_t<decltype(a[0])>, double>)
      return _mm256_fmadd_pd(a, b, c);
    else
      return _mm256_fmadd_ps(a, b, c);
  }
};
#endif
#if defined(__AVX512F__)
template <> struct ContactVector<simd::Avx512> {
  static constexpr std::size_t bytes = 64;
  template <class V> [[gnu::always_inline]] static V multiply_add(V a, V b, V c) noexcept {
    if constexpr (std::is_same_v<std::remove_reference_t<decltype(a[0])>, double>)
      return _mm512_fmadd_pd(a, b, c);
    else
      return _mm512_fmadd_ps(a, b, c);
  }
};
#endif

template <class Set, class T> class ContactLanes final : public ContactKernel<T> {
  using V [[gnu::vector_size(ContactVector<Set>::bytes), gnu::may_alias]] = T;
  static constexpr std::size_t kWidth = sizeof(V) / sizeof(T);
  static constexpr std::size_t kRegisters = kContactLanes / kWidth; // of a turn of the loop

  struct Pair {
    V real, imaginary;
  };
  [[gnu::always_inline]] static V fma(V a, V b, V c) noexcept {
    return ContactVector<Set>::template multiply_add<V>(a, b, c);
  }
  [[gnu::always_inline]] static V load(const T* from) noexcept {
    return *reinterpret_cast<const V*>(from);
  }
  [[gnu::always_inline]] static Pair load(ConstSplitView<T> from, std::size_t i) noexcept {
    return {load(from.real + i), load(from.imaginary + i)};
  }
  [[gnu::always_inline]] static void store(T* to, V value) noexcept {
    *reinterpret_cast<V*>(to) = value;
  }
  [[gnu::always_inline]] static V all(double x) noexcept { return static_cast<T>(x) - V{}; }
  /// z + force b
  [[gnu::always_inline]] static Pair pushed(const Pair& z, const Pair& b, V force) noexcept {
    return {fma(b.real, force, z.real), fma(b.imaginary, force, z.imaginary)};
  }
  /// z + t z
  [[gnu::always_inline]] static Pair turned(const Pair& z, const Pair& t) noexcept {
    return {fma(t.real, z.real, fma(-t.imaginary, z.imaginary, z.real)),
            fma(t.real, z.imaginary, fma(t.imaginary, z.real, z.imaginary))};
  }
  /// Sum of all lanes, halving in registers.
  template <class W> [[gnu::always_inline]] static double halves(W sum) noexcept {
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
      return static_cast<double>(sum[0] + sum[1]);
  }
  /// One sum in several registers, which do not wait for each other.
  struct Sum {
    V part[kRegisters];
    [[gnu::always_inline]] Sum() noexcept {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r)
        part[r] = V{};
    }
    [[gnu::always_inline]] double total() const noexcept {
      V all = part[0];
#pragma GCC unroll 8
      for (std::size_t r = 1; r < kRegisters; ++r)
        all += part[r];
      return halves(all);
    }
  };

  /// Few ears are counted when this is compiled, so that their sums stay in registers.
  [[gnu::always_inline]] static constexpr std::size_t heard_by(std::size_t compiled,
                                                               std::size_t ears) noexcept {
    return compiled < ContactPass<T>::kMostEars ? compiled : ears;
  }
  template <std::size_t Pushes, std::size_t Steps, std::size_t Ears>
  static void advance_by(ContactPass<T>& pass) noexcept {
    const SplitView<T> z = pass.z;
    const ConstSplitView<T> turn = pass.turn, push = pass.push;
    const T* const gain = pass.gain;
    ConstSplitView<T> ear[Ears + 1] = {};
    for (std::size_t e = 0; e < Ears; ++e)
      ear[e] = pass.ear[e < pass.ears ? e : 0];
    Sum first, second, heard[Ears + 1];
    const std::size_t listening = pass.ears < Ears ? pass.ears : Ears;
    const V pending = all(pass.force[0]), last = all(pass.force[Pushes - 1]);
    for (std::size_t k = 0; k < pass.count; k += kContactLanes) {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r) {
        const std::size_t i = k + r * kWidth;
        Pair state{load(z.real + i), load(z.imaginary + i)};
        const Pair t = load(turn, i), b = load(push, i);
        state = turned(pushed(state, b, pending), t);
        if constexpr (Pushes == 2)
          state = turned(pushed(state, b, last), t);
        store(z.real + i, state.real);
        store(z.imaginary + i, state.imaginary);
        const V g = load(gain + i);
        first.part[r] = fma(g, state.imaginary, first.part[r]);
        if constexpr (Steps == 2) {
          state = turned(state, t);
          second.part[r] = fma(g, state.imaginary, second.part[r]);
        }
        for (std::size_t e = 0; e < heard_by(Ears, listening); ++e) {
          const V real = load(ear[e].real + i), imaginary = load(ear[e].imaginary + i);
          heard[e].part[r] =
              fma(real, state.imaginary, fma(imaginary, state.real, heard[e].part[r]));
        }
      }
    }
    pass.place[0] = first.total();
    pass.place[1] = second.total();
    for (std::size_t e = 0; e < heard_by(Ears, listening); ++e)
      pass.heard[e] = heard[e].total();
  }
  template <std::size_t Pushes, std::size_t Steps>
  static void advance_and_hear(ContactPass<T>& pass) noexcept {
    switch (pass.ears) {
    case 0:
      return advance_by<Pushes, Steps, 0>(pass);
    case 1:
      return advance_by<Pushes, Steps, 1>(pass);
    case 2:
      return advance_by<Pushes, Steps, 2>(pass);
    default:
      return advance_by<Pushes, Steps, ContactPass<T>::kMostEars>(pass);
    }
  }

public:
  void advance(ContactPass<T>& pass) const noexcept override {
    if (pass.steps == 1)
      return advance_and_hear<1, 1>(pass);
    if (pass.pushes == 1)
      return advance_and_hear<1, 2>(pass);
    return advance_and_hear<2, 2>(pass);
  }

  void push(SplitView<T> z, ConstSplitView<T> b, double force,
            std::size_t count) const noexcept override {
    const V f = all(force);
    for (std::size_t i = 0; i < count; i += kWidth) {
      store(z.real + i, fma(load(b.real + i), f, load(z.real + i)));
      store(z.imaginary + i, fma(load(b.imaginary + i), f, load(z.imaginary + i)));
    }
  }

  double sum(const T* a, const T* b, std::size_t count) const noexcept override {
    Sum sums;
    for (std::size_t k = 0; k < count; k += kContactLanes) {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r)
        sums.part[r] = fma(load(a + k + r * kWidth), load(b + k + r * kWidth), sums.part[r]);
    }
    return sums.total();
  }

  double hear(ConstSplitView<T> w, ConstSplitView<T> z, std::size_t count) const noexcept override {
    Sum sums;
    for (std::size_t k = 0; k < count; k += kContactLanes) {
#pragma GCC unroll 8
      for (std::size_t r = 0; r < kRegisters; ++r) {
        const Pair a = load(w, k + r * kWidth), b = load(z, k + r * kWidth);
        sums.part[r] = fma(a.real, b.imaginary, fma(a.imaginary, b.real, sums.part[r]));
      }
    }
    return sums.total();
  }
};

} // namespace tactus::modal

#pragma once

#include "core/dsp/vector_set.hpp"

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

// Includes only the intrinsics that the compiler may use here: compiling all of <immintrin.h> takes
// half a second.
#if defined(__AVX__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

/// Lanes<T, N, Set>: N numbers in vector registers, with the operators of one number. A class that
/// is a template over its number type then computes N independent instances at once. Their results
/// have the bits of scalar code, because every operation is the elementwise IEEE operation.
///
/// In place of a branch, such code uses select(mask, a, b).
namespace tactus::simd {

/// Registers of one instruction set.
template <std::floating_point T, class Set> struct Register {
  using Integer = std::conditional_t<sizeof(T) == 8, std::int64_t, std::int32_t>;
  using Vector [[gnu::vector_size(Set::register_bytes)]] = T;
  using Bits [[gnu::vector_size(Set::register_bytes)]] = Integer;
  static constexpr int width = Set::register_bytes / static_cast<int>(sizeof(T));
};

/// Result of a comparison, lane by lane: all bits set where it holds.
template <std::floating_point T, int N, class Set> struct Mask {
  using R = Register<T, Set>;
  static constexpr int registers = N / R::width;
  typename R::Bits v[registers];

  [[gnu::always_inline]] friend Mask operator&(const Mask& a, const Mask& b) noexcept {
    Mask m;
    for (int i = 0; i < registers; ++i)
      m.v[i] = a.v[i] & b.v[i];
    return m;
  }
  [[gnu::always_inline]] friend Mask operator|(const Mask& a, const Mask& b) noexcept {
    Mask m;
    for (int i = 0; i < registers; ++i)
      m.v[i] = a.v[i] | b.v[i];
    return m;
  }
  [[gnu::always_inline]] friend Mask operator!(const Mask& a) noexcept {
    Mask m;
    for (int i = 0; i < registers; ++i)
      m.v[i] = ~a.v[i];
    return m;
  }
};

/// N numbers computed together; N is a multiple of the register's width.
template <std::floating_point T, int N, class Set = Baseline> struct Lanes {
  using R = Register<T, Set>;
  using MaskType = Mask<T, N, Set>;
  static constexpr int registers = N / R::width;
  static_assert(registers * R::width == N);
  typename R::Vector v[registers];

  Lanes() = default;
  /// The same number in every lane.
  [[gnu::always_inline]] Lanes(double value) noexcept {
    for (int i = 0; i < registers; ++i)
      v[i] = static_cast<T>(value) - typename R::Vector{}; // x - 0 is x, also for -0
  }

  [[gnu::always_inline]] friend Lanes operator+(const Lanes& a, const Lanes& b) noexcept {
    Lanes r;
    for (int i = 0; i < registers; ++i)
      r.v[i] = a.v[i] + b.v[i];
    return r;
  }
  [[gnu::always_inline]] friend Lanes operator-(const Lanes& a, const Lanes& b) noexcept {
    Lanes r;
    for (int i = 0; i < registers; ++i)
      r.v[i] = a.v[i] - b.v[i];
    return r;
  }
  [[gnu::always_inline]] friend Lanes operator*(const Lanes& a, const Lanes& b) noexcept {
    Lanes r;
    for (int i = 0; i < registers; ++i)
      r.v[i] = a.v[i] * b.v[i];
    return r;
  }
  [[gnu::always_inline]] friend Lanes operator/(const Lanes& a, const Lanes& b) noexcept {
    Lanes r;
    for (int i = 0; i < registers; ++i)
      r.v[i] = a.v[i] / b.v[i];
    return r;
  }
  [[gnu::always_inline]] friend Lanes operator-(const Lanes& a) noexcept {
    Lanes r;
    for (int i = 0; i < registers; ++i)
      r.v[i] = -a.v[i];
    return r;
  }
  [[gnu::always_inline]] Lanes& operator+=(const Lanes& b) noexcept { return *this = *this + b; }
  [[gnu::always_inline]] Lanes& operator-=(const Lanes& b) noexcept { return *this = *this - b; }
  [[gnu::always_inline]] Lanes& operator*=(const Lanes& b) noexcept { return *this = *this * b; }
  [[gnu::always_inline]] friend MaskType operator<(const Lanes& a, const Lanes& b) noexcept {
    MaskType m;
    for (int i = 0; i < registers; ++i)
      m.v[i] = a.v[i] < b.v[i];
    return m;
  }
  [[gnu::always_inline]] friend MaskType operator<=(const Lanes& a, const Lanes& b) noexcept {
    MaskType m;
    for (int i = 0; i < registers; ++i)
      m.v[i] = a.v[i] <= b.v[i];
    return m;
  }
  [[gnu::always_inline]] friend MaskType operator>(const Lanes& a, const Lanes& b) noexcept {
    return b < a;
  }
  [[gnu::always_inline]] friend MaskType operator>=(const Lanes& a, const Lanes& b) noexcept {
    return b <= a;
  }
};

/// Number of lanes and their types; a scalar is one lane.
template <class V> struct LaneTraits {
  static constexpr int count = 1;
  using Scalar = V;
  using MaskType = bool;
};
template <class T, int N, class Set> struct LaneTraits<Lanes<T, N, Set>> {
  static constexpr int count = N;
  using Scalar = T;
  using MaskType = Mask<T, N, Set>;
};

// One lane.
template <std::floating_point T>
[[nodiscard, gnu::always_inline]] inline T select(bool mask, T yes, T no) noexcept {
  return mask ? yes : no;
}
template <std::floating_point T>
[[nodiscard, gnu::always_inline]] inline T square_root(T x) noexcept {
  return std::sqrt(x);
}
template <std::floating_point T> [[nodiscard, gnu::always_inline]] inline T absolute(T x) noexcept {
  return std::abs(x);
}
template <std::floating_point T>
[[nodiscard, gnu::always_inline]] inline T copy_sign(T size, T from) noexcept {
  return std::copysign(size, from);
}
[[nodiscard, gnu::always_inline]] inline bool any(bool mask) noexcept { return mask; }
template <std::floating_point T>
[[nodiscard, gnu::always_inline]] inline T lane(T x, int) noexcept {
  return x;
}
[[nodiscard, gnu::always_inline]] inline bool lane(bool mask, int) noexcept { return mask; }
template <std::floating_point T>
[[gnu::always_inline]] inline void set_lane(T& x, int, T value) noexcept {
  x = value;
}

// Several lanes.
template <class T, int N, class Set>
[[nodiscard, gnu::always_inline]] inline Lanes<T, N, Set>
select(const Mask<T, N, Set>& mask, const Lanes<T, N, Set>& yes,
       const Lanes<T, N, Set>& no) noexcept {
  Lanes<T, N, Set> r;
  for (int i = 0; i < r.registers; ++i)
    r.v[i] = mask.v[i] ? yes.v[i] : no.v[i];
  return r;
}

template <class T, int N, class Set>
[[nodiscard, gnu::always_inline]] inline Lanes<T, N, Set>
square_root(const Lanes<T, N, Set>& x) noexcept {
  Lanes<T, N, Set> r;
  for (int i = 0; i < r.registers; ++i) {
#if defined(__AVX2__)
    if constexpr (Set::register_bytes == 32) {
      if constexpr (sizeof(T) == 8)
        r.v[i] = _mm256_sqrt_pd(x.v[i]);
      else
        r.v[i] = _mm256_sqrt_ps(x.v[i]);
      continue;
    }
#endif
#if defined(__SSE2__)
    if constexpr (Set::register_bytes == 16) {
      if constexpr (sizeof(T) == 8)
        r.v[i] = _mm_sqrt_pd(x.v[i]);
      else
        r.v[i] = _mm_sqrt_ps(x.v[i]);
      continue;
    }
#endif
    for (int k = 0; k < Register<T, Set>::width; ++k)
      r.v[i][k] = std::sqrt(x.v[i][k]);
  }
  return r;
}

template <class T, int N, class Set>
[[nodiscard, gnu::always_inline]] inline Lanes<T, N, Set>
absolute(const Lanes<T, N, Set>& x) noexcept {
  using R = Register<T, Set>;
  const Lanes<T, N, Set> sign(-0.0);
  Lanes<T, N, Set> r;
  for (int i = 0; i < r.registers; ++i)
    r.v[i] = reinterpret_cast<typename R::Vector>(reinterpret_cast<typename R::Bits>(x.v[i]) &
                                                  ~reinterpret_cast<typename R::Bits>(sign.v[i]));
  return r;
}

template <class T, int N, class Set>
[[nodiscard, gnu::always_inline]] inline Lanes<T, N, Set>
copy_sign(const Lanes<T, N, Set>& size, const Lanes<T, N, Set>& from) noexcept {
  using R = Register<T, Set>;
  const Lanes<T, N, Set> sign(-0.0);
  Lanes<T, N, Set> r;
  for (int i = 0; i < r.registers; ++i) {
    const auto sign_mask = reinterpret_cast<typename R::Bits>(sign.v[i]);
    r.v[i] = reinterpret_cast<typename R::Vector>(
        (reinterpret_cast<typename R::Bits>(size.v[i]) & ~sign_mask) |
        (reinterpret_cast<typename R::Bits>(from.v[i]) & sign_mask));
  }
  return r;
}

/// True when the comparison holds in at least one lane.
template <class T, int N, class Set>
[[nodiscard, gnu::always_inline]] inline bool any(const Mask<T, N, Set>& mask) noexcept {
  auto combined = mask.v[0];
  for (int i = 1; i < mask.registers; ++i)
    combined |= mask.v[i];
#if defined(__AVX2__)
  if constexpr (Set::register_bytes == 32)
    return _mm256_movemask_epi8(reinterpret_cast<__m256i>(combined)) != 0;
#endif
#if defined(__SSE2__)
  if constexpr (Set::register_bytes == 16)
    return _mm_movemask_epi8(reinterpret_cast<__m128i>(combined)) != 0;
#endif
  typename Register<T, Set>::Integer found = 0;
  for (int k = 0; k < Register<T, Set>::width; ++k)
    found |= combined[k];
  return found != 0;
}

/// Bit i is 1 if the comparison holds in lane i; for at most 32 lanes.
[[nodiscard, gnu::always_inline]] inline std::uint32_t bits(bool mask) noexcept { return mask; }
template <class T, int N, class Set>
[[nodiscard, gnu::always_inline]] inline std::uint32_t bits(const Mask<T, N, Set>& mask) noexcept {
  static_assert(N <= 32);
  constexpr int width = Register<T, Set>::width;
  std::uint32_t found = 0;
  for (int i = 0; i < mask.registers; ++i) {
    int register_bits = 0;
#if defined(__AVX2__)
    if constexpr (Set::register_bytes == 32) {
      register_bits = sizeof(T) == 8 ? _mm256_movemask_pd(reinterpret_cast<__m256d>(mask.v[i]))
                                     : _mm256_movemask_ps(reinterpret_cast<__m256>(mask.v[i]));
      found |= static_cast<std::uint32_t>(register_bits) << (i * width);
      continue;
    }
#endif
#if defined(__SSE2__)
    if constexpr (Set::register_bytes == 16) {
      register_bits = sizeof(T) == 8 ? _mm_movemask_pd(reinterpret_cast<__m128d>(mask.v[i]))
                                     : _mm_movemask_ps(reinterpret_cast<__m128>(mask.v[i]));
      found |= static_cast<std::uint32_t>(register_bits) << (i * width);
      continue;
    }
#endif
    for (int k = 0; k < width; ++k)
      register_bits |= static_cast<int>(mask.v[i][k] != 0) << k;
    found |= static_cast<std::uint32_t>(register_bits) << (i * width);
  }
  return found;
}

template <class T, int N, class Set>
[[nodiscard, gnu::always_inline]] inline T lane(const Lanes<T, N, Set>& x, int i) noexcept {
  return x.v[i / Register<T, Set>::width][i % Register<T, Set>::width];
}
template <class T, int N, class Set>
[[nodiscard, gnu::always_inline]] inline bool lane(const Mask<T, N, Set>& mask, int i) noexcept {
  return mask.v[i / Register<T, Set>::width][i % Register<T, Set>::width] != 0;
}
template <class T, int N, class Set>
[[gnu::always_inline]] inline void set_lane(Lanes<T, N, Set>& x, int i, T value) noexcept {
  x.v[i / Register<T, Set>::width][i % Register<T, Set>::width] = value;
}

template <class V>
[[nodiscard, gnu::always_inline]] inline V minimum(const V& a, const V& b) noexcept {
  return select(b < a, b, a);
}
template <class V>
[[nodiscard, gnu::always_inline]] inline V maximum(const V& a, const V& b) noexcept {
  return select(a < b, b, a);
}

} // namespace tactus::simd

#pragma once

#include "core/modal/bank_kernel.hpp"

/// The mode bank's loops, written once for any instruction set. Every function is a template on the
/// set, so that the linker never takes a newer processor's code for an older one's.
///
/// Modes lie across lanes. The outputs of a leap of eight samples come straight from the state at
/// its beginning by a table of the pole's powers, and so does the state at its end: there is no
/// recursion from sample to sample to wait for, rounding enters once in eight samples, and pitch is
/// as good as the table. Costs 4 fused multiply-adds a mode and sample with one force and one
/// pick-up, and 9 in eight samples for gains and the step of the state.
namespace tactus::modal {

template <class Set> struct BankVector;

template <> struct BankVector<simd::Baseline> {
  using Type [[gnu::vector_size(16)]] = float;
  static constexpr std::size_t width = 4, tile = 2;
  static Type multiply_add(Type a, Type b, Type c) noexcept { return a * b + c; }
};
#if defined(__AVX2__) && defined(__FMA__)
template <> struct BankVector<simd::Avx2> {
  using Type [[gnu::vector_size(32)]] = float;
  static constexpr std::size_t width = 8, tile = 2;
  [[gnu::always_inline]] static Type multiply_add(Type a, Type b, Type c) noexcept {
    return _mm256_fmadd_ps(a, b, c);
  }
};
#endif
#if defined(__AVX512F__)
template <> struct BankVector<simd::Avx512> {
  using Type [[gnu::vector_size(64)]] = float;
  static constexpr std::size_t width = 16, tile = 4;
  [[gnu::always_inline]] static Type multiply_add(Type a, Type b, Type c) noexcept {
    return _mm512_fmadd_ps(a, b, c);
  }
};
#endif

template <class Set> class BankLanes final : public BankKernel {
  using Traits = BankVector<Set>;
  using V = typename Traits::Type;
  static constexpr std::size_t kWidth = Traits::width;
  static constexpr std::size_t kRegisters = 2; // in flight, summed into one accumulator
  static constexpr std::size_t kStep = kRegisters * kWidth;

  [[gnu::always_inline]] static V fma(V a, V b, V c) noexcept {
    return Traits::multiply_add(a, b, c);
  }
  [[gnu::always_inline]] static V load(const Lane& lane, std::size_t at) noexcept {
    return *reinterpret_cast<const V*>(lane.v + at);
  }
  [[gnu::always_inline]] static void store(Lane& lane, std::size_t at, V value) noexcept {
    *reinterpret_cast<V*>(lane.v + at) = value;
  }
  [[gnu::always_inline]] static V all(float x) noexcept { return x - V{}; }

  /// Two registers of complex numbers.
  struct Pair {
    V real[kRegisters], imaginary[kRegisters];
  };
  [[gnu::always_inline]] static Pair load(const ComplexLane& lane, std::size_t at) noexcept {
    Pair p;
    for (std::size_t r = 0; r < kRegisters; ++r) {
      p.real[r] = load(lane.real, at + r * kWidth);
      p.imaginary[r] = load(lane.imaginary, at + r * kWidth);
    }
    return p;
  }
  [[gnu::always_inline]] static void store(ComplexLane& lane, std::size_t at,
                                           const Pair& p) noexcept {
    for (std::size_t r = 0; r < kRegisters; ++r) {
      store(lane.real, at + r * kWidth, p.real[r]);
      store(lane.imaginary, at + r * kWidth, p.imaginary[r]);
    }
  }
  [[gnu::always_inline]] static Pair power(const PoleBlock& poles, std::size_t exponent,
                                           std::size_t at) noexcept {
    Pair p;
    for (std::size_t r = 0; r < kRegisters; ++r) {
      p.real[r] = load(poles.real[exponent - 1], at + r * kWidth);
      p.imaginary[r] = load(poles.imaginary[exponent - 1], at + r * kWidth);
    }
    return p;
  }
  /// a b + c
  [[gnu::always_inline]] static Pair multiply_add(const Pair& a, const Pair& b,
                                                  const Pair& c) noexcept {
    Pair out;
    for (std::size_t r = 0; r < kRegisters; ++r) {
      out.real[r] = fma(a.real[r], b.real[r], fma(-a.imaginary[r], b.imaginary[r], c.real[r]));
      out.imaginary[r] =
          fma(a.real[r], b.imaginary[r], fma(a.imaginary[r], b.real[r], c.imaginary[r]));
    }
    return out;
  }

  /// sum over j < samples of p^(samples-1-j) x[j], for Tile leaps at a stride of kLeap samples.
  template <std::size_t Tile>
  [[gnu::always_inline]] static void gather(const PoleBlock& poles, std::size_t at,
                                            const float* force, std::size_t samples,
                                            Pair* sum) noexcept {
    for (std::size_t t = 0; t < Tile; ++t)
      sum[t] = {};
    for (std::size_t j = 0; j + 1 < samples; ++j) {
      const Pair p = power(poles, samples - 1 - j, at);
      for (std::size_t t = 0; t < Tile; ++t) {
        const V x = all(force[t * kLeap + j]);
        for (std::size_t r = 0; r < kRegisters; ++r) {
          sum[t].real[r] = fma(p.real[r], x, sum[t].real[r]);
          sum[t].imaginary[r] = fma(p.imaginary[r], x, sum[t].imaginary[r]);
        }
      }
    }
    for (std::size_t t = 0; t < Tile; ++t)
      for (std::size_t r = 0; r < kRegisters; ++r)
        sum[t].real[r] += all(force[t * kLeap + samples - 1]);
  }

  /// input[l] += gain * gather of leap l
  template <std::size_t Tile>
  [[gnu::always_inline]] static void drive(const PoleBlock& poles, std::size_t at,
                                           const Lane& gain, const float* force,
                                           std::size_t samples, Pair* input) noexcept {
    Pair sum[Tile];
    gather<Tile>(poles, at, force, samples, sum);
    for (std::size_t t = 0; t < Tile; ++t)
      for (std::size_t r = 0; r < kRegisters; ++r) {
        const V b = load(gain, at + r * kWidth);
        input[t].real[r] = fma(b, sum[t].real[r], input[t].real[r]);
        input[t].imaginary[r] = fma(b, sum[t].imaginary[r], input[t].imaginary[r]);
      }
  }

  /// Adds Im(p^(i+1) c) to the accumulators of samples first + i, for Tile leaps.
  template <std::size_t Tile>
  [[gnu::always_inline]] static void hear(const PoleBlock& poles, std::size_t at, const Pair* heard,
                                          std::size_t first, std::size_t count,
                                          V* accumulator) noexcept {
    for (std::size_t i = 0; i < count; ++i) {
      const Pair p = power(poles, first + i + 1, at);
      for (std::size_t t = 0; t < Tile; ++t) {
        V sum = accumulator[t * kLeap + i];
        for (std::size_t r = 0; r < kRegisters; ++r) {
          sum = fma(p.real[r], heard[t].imaginary[r], sum);
          sum = fma(p.imaginary[r], heard[t].real[r], sum);
        }
        accumulator[t * kLeap + i] = sum;
      }
    }
  }

  /// Sums the lanes of every accumulator, always in the same order.
  static void collect(const V* accumulator, std::size_t count, float* out) noexcept {
    for (std::size_t n = 0; n < count; ++n) {
      V sum = accumulator[n];
      using Four [[gnu::vector_size(16)]] = float;
      Four folded;
      if constexpr (kWidth == 16) {
        using Eight [[gnu::vector_size(32)]] = float;
        const Eight half = __builtin_shufflevector(sum, sum, 0, 1, 2, 3, 4, 5, 6, 7) +
                           __builtin_shufflevector(sum, sum, 8, 9, 10, 11, 12, 13, 14, 15);
        folded = __builtin_shufflevector(half, half, 0, 1, 2, 3) +
                 __builtin_shufflevector(half, half, 4, 5, 6, 7);
      } else if constexpr (kWidth == 8) {
        folded = __builtin_shufflevector(sum, sum, 0, 1, 2, 3) +
                 __builtin_shufflevector(sum, sum, 4, 5, 6, 7);
      } else {
        folded = sum;
      }
      out[n] = (folded[0] + folded[2]) + (folded[1] + folded[3]);
    }
  }

public:
  void run(const BankView& bank, std::size_t leaps, std::span<const BankDrive> drives,
           std::span<const BankPickup> pickups) const noexcept override {
    V accumulator[kMostEars][kMostSamples];
    const std::size_t heard_count = pickups.size() < kMostEars ? pickups.size() : kMostEars;
    for (std::size_t k = 0; k < heard_count; ++k)
      for (std::size_t n = 0; n < leaps * kLeap; ++n)
        accumulator[k][n] = V{};
    for (const std::uint32_t block : bank.active) {
      const PoleBlock& poles = bank.poles[block];
      for (std::size_t at = 0; at < kLanes; at += kStep) {
        Pair input[kMostLeaps], state[kMostLeaps];
        for (std::size_t l = 0; l < leaps; ++l)
          input[l] = {};
        for (const BankDrive& d : drives) {
          std::size_t l = 0;
          for (; l + 2 <= leaps; l += 2)
            drive<2>(poles, at, d.gain[block], d.force + l * kLeap, kLeap, input + l);
          if (l < leaps)
            drive<1>(poles, at, d.gain[block], d.force + l * kLeap, kLeap, input + l);
        }
        Pair z = load(bank.state[block], at);
        const Pair leap = power(poles, kLeap, at);
        for (std::size_t l = 0; l < leaps; ++l) {
          state[l] = z;
          z = multiply_add(leap, z, input[l]);
        }
        store(bank.state[block], at, z);
        for (std::size_t k = 0; k < heard_count; ++k) {
          const Pair weight = load(pickups[k].weight[block], at);
          for (std::size_t l = 0; l < leaps; ++l)
            input[l] = multiply_add(weight, state[l], {});
          std::size_t l = 0;
          for (; l + Traits::tile <= leaps; l += Traits::tile)
            hear<Traits::tile>(poles, at, input + l, 0, kLeap, accumulator[k] + l * kLeap);
          for (; l < leaps; ++l)
            hear<1>(poles, at, input + l, 0, kLeap, accumulator[k] + l * kLeap);
        }
      }
    }
    for (std::size_t k = 0; k < heard_count; ++k)
      collect(accumulator[k], leaps * kLeap, pickups[k].out);
  }

  void listen(const BankView& bank, std::size_t first, std::size_t count,
              std::span<const BankPickup> pickups) const noexcept override {
    for (const BankPickup& pickup : pickups) {
      V accumulator[kLeap] = {};
      for (const std::uint32_t block : bank.active)
        for (std::size_t at = 0; at < kLanes; at += kStep) {
          const Pair heard =
              multiply_add(load(pickup.weight[block], at), load(bank.state[block], at), {});
          hear<1>(bank.poles[block], at, &heard, first, count, accumulator);
        }
      collect(accumulator, count, pickup.out);
    }
  }

  void advance(const BankView& bank, std::size_t samples,
               std::span<const BankDrive> drives) const noexcept override {
    for (const std::uint32_t block : bank.active)
      for (std::size_t at = 0; at < kLanes; at += kStep) {
        Pair input{};
        for (const BankDrive& d : drives)
          drive<1>(bank.poles[block], at, d.gain[block], d.force, samples, &input);
        const Pair z = multiply_add(power(bank.poles[block], samples, at),
                                    load(bank.state[block], at), input);
        store(bank.state[block], at, z);
      }
  }
};

} // namespace tactus::modal

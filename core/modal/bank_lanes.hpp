#pragma once

#include "core/modal/bank_kernel.hpp"

/// The mode bank's loops, written once for any instruction set. Every function is a template on the
/// set, so that the linker never takes a newer processor's code for an older one's.
///
/// Modes lie across lanes. All outputs of a leap of sixteen samples come straight from the state at
/// its beginning by a table, and so does the state at its end from the forces: there is no recursion
/// from sample to sample to wait for, rounding enters once in sixteen samples, and pitch is as good
/// as the table. Powers of the pole cost 4 fused multiply-adds a mode and sample for one force and
/// one pick-up, and 10 in sixteen samples for gains and the step of the state.
///
/// Half of that is saved where modes decay alike. Seen from the middle of the leap, a mode that does
/// not decay gives E + O at a time t after and E - O at the same time before, E = Im(c) cos and
/// O = Re(c) sin of omega t: one product for each sample. A decay that all share is put in
/// afterwards; what a mode's own decay differs from it (at most ModeBank::kUnlike) is put right from
/// leap to leap, because the state's step is exact, and errs by that difference times eight samples
/// in between.
namespace tactus::modal {

template <class Set> struct BankVector;

template <> struct BankVector<simd::Baseline> {
  using Type [[gnu::vector_size(16)]] = float;
  static constexpr std::size_t width = 4, registers = 2, tile = 2;
  static Type multiply_add(Type a, Type b, Type c) noexcept { return a * b + c; }
};
#if defined(__AVX2__) && defined(__FMA__)
template <> struct BankVector<simd::Avx2> {
  using Type [[gnu::vector_size(32)]] = float;
  static constexpr std::size_t width = 8, registers = 2, tile = 2;
  [[gnu::always_inline]] static Type multiply_add(Type a, Type b, Type c) noexcept {
    return _mm256_fmadd_ps(a, b, c);
  }
};
#endif
#if defined(__AVX512F__)
template <> struct BankVector<simd::Avx512> {
  using Type [[gnu::vector_size(64)]] = float;
  static constexpr std::size_t width = 16, registers = 2, tile = 4;
  [[gnu::always_inline]] static Type multiply_add(Type a, Type b, Type c) noexcept {
    return _mm512_fmadd_ps(a, b, c);
  }
};
#endif

template <class Set> class BankLanes final : public BankKernel {
  using Traits = BankVector<Set>;
  using V = typename Traits::Type;
  static constexpr std::size_t kWidth = Traits::width;
  static constexpr std::size_t kRegisters = Traits::registers; // summed into one accumulator
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

  /// Some registers of complex numbers.
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
  /// p^exponent of an uneven block.
  [[gnu::always_inline]] static Pair power(const PoleBlock& poles, std::size_t exponent,
                                           std::size_t at) noexcept {
    return load(poles.power[exponent - 1], at);
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

  /// input[t] += gain times the sum over j of p^(15-j) x[j], for Tile leaps one after the other.
  template <std::size_t Tile>
  [[gnu::always_inline]] static void gather(const PoleBlock& poles, std::size_t at,
                                            const Lane& gain, const float* force,
                                            Pair* input) noexcept {
    Pair sum[Tile];
    for (std::size_t t = 0; t < Tile; ++t)
      for (std::size_t r = 0; r < kRegisters; ++r) {
        sum[t].real[r] = all(force[t * kLeap + kLeap - 1]);
        sum[t].imaginary[r] = V{};
      }
    for (std::size_t j = 0; j + 1 < kLeap; ++j) {
      const Pair p = power(poles, kLeap - 1 - j, at);
      for (std::size_t t = 0; t < Tile; ++t) {
        const V x = all(force[t * kLeap + j]);
        for (std::size_t r = 0; r < kRegisters; ++r) {
          sum[t].real[r] = fma(p.real[r], x, sum[t].real[r]);
          sum[t].imaginary[r] = fma(p.imaginary[r], x, sum[t].imaginary[r]);
        }
      }
    }
    add_gained<Tile>(gain, at, sum, input);
  }

  /// The same seen from the middle, from the forces' sums and differences about it.
  template <std::size_t Tile>
  [[gnu::always_inline]] static void gather_even(const PoleBlock& poles, std::size_t at,
                                                 const Lane& gain, const float* sums,
                                                 const float* differences, Pair* input) noexcept {
    Pair sum[Tile] = {};
    for (std::size_t m = 0; m < kHalfLeap; ++m) {
      const Pair p = load(poles.power[m], at);
      for (std::size_t t = 0; t < Tile; ++t) {
        const V even = all(sums[t * kHalfLeap + m]), odd = all(differences[t * kHalfLeap + m]);
        for (std::size_t r = 0; r < kRegisters; ++r) {
          sum[t].real[r] = fma(p.real[r], even, sum[t].real[r]);
          sum[t].imaginary[r] = fma(p.imaginary[r], odd, sum[t].imaginary[r]);
        }
      }
    }
    add_gained<Tile>(gain, at, sum, input);
  }

  template <std::size_t Tile>
  [[gnu::always_inline]] static void add_gained(const Lane& gain, std::size_t at, const Pair* sum,
                                                Pair* input) noexcept {
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

  /// What an even block adds at times m + 1/2 from the middle, first <= m < last.
  template <std::size_t Tile>
  [[gnu::always_inline]] static void hear_even(const PoleBlock& poles, std::size_t at,
                                               const Pair* given, std::size_t first,
                                               std::size_t last, V* even, V* odd) noexcept {
    Pair heard[Tile];
    for (std::size_t t = 0; t < Tile; ++t)
      heard[t] = given[t];
    for (std::size_t m = first; m < last; ++m) {
      const Pair p = load(poles.power[m], at);
      for (std::size_t t = 0; t < Tile; ++t) {
        V e = even[t * kHalfLeap + m], o = odd[t * kHalfLeap + m];
        for (std::size_t r = 0; r < kRegisters; ++r) {
          e = fma(p.real[r], heard[t].imaginary[r], e);
          o = fma(p.imaginary[r], heard[t].real[r], o);
        }
        even[t * kHalfLeap + m] = e;
        odd[t * kHalfLeap + m] = o;
      }
    }
  }

  /// Sums that even blocks of one common decay build up in a leap, before the decay.
  struct Halves {
    V even[kMostLeaps * kHalfLeap], odd[kMostLeaps * kHalfLeap];
  };
  [[gnu::always_inline]] static V later(const CommonDecay& decay, std::size_t m, V even,
                                        V odd) noexcept {
    return all(decay.fall[m]) * (even + odd);
  }
  [[gnu::always_inline]] static V earlier(const CommonDecay& decay, std::size_t m, V even,
                                          V odd) noexcept {
    return all(decay.rise[m]) * (even - odd);
  }
  static void join(Halves& halves, const CommonDecay& decay, std::size_t leaps,
                   V* accumulator) noexcept {
    for (std::size_t l = 0; l < leaps; ++l)
      for (std::size_t m = 0; m < kHalfLeap; ++m) {
        V& e = halves.even[l * kHalfLeap + m];
        V& o = halves.odd[l * kHalfLeap + m];
        accumulator[l * kLeap + kHalfLeap + m] += later(decay, m, e, o);
        accumulator[l * kLeap + kHalfLeap - 1 - m] += earlier(decay, m, e, o);
        e = o = V{};
      }
  }
  /// A force's sums and differences about the middles of its leaps, the decay taken into account.
  static void fold(const float* force, const CommonDecay& decay, std::size_t leaps, float* sums,
                   float* differences) noexcept {
    for (std::size_t l = 0; l < leaps; ++l)
      for (std::size_t m = 0; m < kHalfLeap; ++m) {
        const float before = force[l * kLeap + kHalfLeap - 1 - m] * decay.fall[m];
        const float after = force[l * kLeap + kHalfLeap + m] * decay.rise[m];
        sums[l * kHalfLeap + m] = before + after;
        differences[l * kHalfLeap + m] = before - after;
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

  static constexpr std::uint32_t kNone = 0xffffffff;

  /// Forces folded for the common decay at work, one drive after the other.
  struct Folded {
    static constexpr std::size_t kMostDrives = 72;
    float sums[kMostDrives][kMostLeaps * kHalfLeap];
    float differences[kMostDrives][kMostLeaps * kHalfLeap];
  };

  /// States at the beginning of each leap, or in its middle, and the state after all.
  [[gnu::always_inline]] static void step(const PoleBlock& poles, const BankView& bank,
                                          std::uint32_t block, std::size_t at, std::size_t leaps,
                                          std::span<const BankDrive> drives, const Folded& folded,
                                          Pair* state) noexcept {
    Pair input[kMostLeaps];
    for (std::size_t l = 0; l < leaps; ++l)
      input[l] = {};
    for (std::size_t d = 0; d < drives.size(); ++d) {
      const Lane& gain = drives[d].gain[block];
      const auto take = [&]<std::size_t Tile>(std::size_t l) {
        if (poles.even)
          gather_even<Tile>(poles, at, gain, folded.sums[d] + l * kHalfLeap,
                            folded.differences[d] + l * kHalfLeap, input + l);
        else
          gather<Tile>(poles, at, gain, drives[d].force + l * kLeap, input + l);
      };
      std::size_t l = 0;
      for (; l + Traits::tile <= leaps; l += Traits::tile)
        take.template operator()<Traits::tile>(l);
      for (; l < leaps; ++l)
        take.template operator()<1>(l);
    }
    Pair z = load(bank.state[block], at);
    const Pair leap = load(poles.whole_leap(), at);
    for (std::size_t l = 0; l < leaps; ++l) {
      state[l] = z;
      if (poles.even) {
        for (std::size_t r = 0; r < kRegisters; ++r) {
          z.real[r] += input[l].real[r];
          z.imaginary[r] += input[l].imaginary[r];
        }
        z = multiply_add(leap, z, {});
      } else {
        z = multiply_add(leap, z, input[l]);
      }
    }
    store(bank.state[block], at, z);
  }

public:
  void run(const BankView& bank, std::size_t leaps, std::span<const BankDrive> drives,
           std::span<const BankPickup> pickups) const noexcept override {
    V accumulator[kMostEars][kMostSamples];
    Halves halves[kMostEars];
    Folded folded;
    const std::size_t ears = pickups.size() < kMostEars ? pickups.size() : kMostEars;
    for (std::size_t k = 0; k < ears; ++k) {
      for (std::size_t n = 0; n < leaps * kLeap; ++n)
        accumulator[k][n] = V{};
      for (std::size_t n = 0; n < leaps * kHalfLeap; ++n)
        halves[k].even[n] = halves[k].odd[n] = V{};
    }
    std::uint32_t decay = kNone;
    for (const std::uint32_t block : bank.active) {
      const PoleBlock& poles = bank.poles[block];
      if (poles.even && poles.decay != decay) {
        for (std::size_t k = 0; k < ears && decay != kNone; ++k)
          join(halves[k], bank.decays[decay], leaps, accumulator[k]);
        decay = poles.decay;
        for (std::size_t d = 0; d < drives.size(); ++d)
          fold(drives[d].force, bank.decays[decay], leaps, folded.sums[d], folded.differences[d]);
      }
      for (std::size_t at = 0; at < kLanes; at += kStep) {
        Pair state[kMostLeaps], heard[kMostLeaps];
        step(poles, bank, block, at, leaps, drives, folded, state);
        for (std::size_t k = 0; k < ears; ++k) {
          const Pair weight = load(pickups[k].weight[block], at);
          for (std::size_t l = 0; l < leaps; ++l)
            heard[l] = multiply_add(weight, state[l], {});
          const auto listen_to = [&]<std::size_t Tile>(std::size_t l) {
            if (poles.even)
              hear_even<Tile>(poles, at, heard + l, 0, kHalfLeap, halves[k].even + l * kHalfLeap,
                              halves[k].odd + l * kHalfLeap);
            else
              hear<Tile>(poles, at, heard + l, 0, kLeap, accumulator[k] + l * kLeap);
          };
          std::size_t l = 0;
          for (; l + Traits::tile <= leaps; l += Traits::tile)
            listen_to.template operator()<Traits::tile>(l);
          for (; l < leaps; ++l)
            listen_to.template operator()<1>(l);
        }
      }
    }
    for (std::size_t k = 0; k < ears; ++k) {
      if (decay != kNone)
        join(halves[k], bank.decays[decay], leaps, accumulator[k]);
      collect(accumulator[k], leaps * kLeap, pickups[k].out);
    }
  }

  void listen(const BankView& bank, std::size_t first, std::size_t count,
              std::span<const BankPickup> pickups) const noexcept override {
    // The same sums in the same order as run() has them, for these samples alone.
    for (const BankPickup& pickup : pickups) {
      V accumulator[kLeap] = {};
      Halves halves;
      for (std::size_t m = 0; m < kHalfLeap; ++m)
        halves.even[m] = halves.odd[m] = V{};
      std::uint32_t decay = kNone;
      const auto join_these = [&] {
        for (std::size_t i = 0; i < count; ++i) {
          const std::size_t n = first + i;
          const std::size_t m = n < kHalfLeap ? kHalfLeap - 1 - n : n - kHalfLeap;
          const V e = halves.even[m], o = halves.odd[m];
          accumulator[i] += n < kHalfLeap ? earlier(bank.decays[decay], m, e, o)
                                          : later(bank.decays[decay], m, e, o);
        }
        for (std::size_t m = 0; m < kHalfLeap; ++m)
          halves.even[m] = halves.odd[m] = V{};
      };
      for (const std::uint32_t block : bank.active) {
        const PoleBlock& poles = bank.poles[block];
        if (poles.even && poles.decay != decay) {
          if (decay != kNone)
            join_these();
          decay = poles.decay;
        }
        for (std::size_t at = 0; at < kLanes; at += kStep) {
          const Pair heard =
              multiply_add(load(pickup.weight[block], at), load(bank.state[block], at), {});
          if (!poles.even) {
            hear<1>(poles, at, &heard, first, count, accumulator);
            continue;
          }
          bool needed[kHalfLeap] = {};
          for (std::size_t i = 0; i < count; ++i) {
            const std::size_t n = first + i;
            needed[n < kHalfLeap ? kHalfLeap - 1 - n : n - kHalfLeap] = true;
          }
          for (std::size_t m = 0; m < kHalfLeap; ++m)
            if (needed[m])
              hear_even<1>(poles, at, &heard, m, m + 1, halves.even, halves.odd);
        }
      }
      if (decay != kNone)
        join_these();
      collect(accumulator, count, pickup.out);
    }
  }

  void echo(const float* force, const float* response, float* out) const noexcept override {
    constexpr std::size_t kParts = kLeap / kWidth;
    using Unaligned [[gnu::vector_size(sizeof(V)), gnu::aligned(4), gnu::may_alias]] = float;
    V sum[kParts] = {};
    for (std::size_t j = 0; j < kLeap; ++j)
      for (std::size_t part = 0; part < kParts; ++part) {
        const float* at = response + kLeap + part * kWidth - j;
        sum[part] = fma(all(force[j]), *reinterpret_cast<const Unaligned*>(at), sum[part]);
      }
    for (std::size_t part = 0; part < kParts; ++part)
      *reinterpret_cast<Unaligned*>(out + part * kWidth) = sum[part];
  }

  void advance(const BankView& bank, std::size_t samples,
               std::span<const BankDrive> drives) const noexcept override {
    Folded folded;
    for (const std::uint32_t block : bank.active) {
      const PoleBlock& poles = bank.poles[block];
      if (samples == kLeap && poles.even)
        for (std::size_t d = 0; d < drives.size(); ++d)
          fold(drives[d].force, bank.decays[poles.decay], 1, folded.sums[d],
               folded.differences[d]);
      for (std::size_t at = 0; at < kLanes; at += kStep) {
        Pair state[kMostLeaps];
        if (samples == kLeap) {
          step(poles, bank, block, at, 1, drives, folded, state);
          continue;
        }
        Pair z = load(bank.state[block], at);
        if (poles.even)
          z = multiply_add(load(poles.power[PoleBlock::kFromMiddle], at), z, {});
        const Pair p = load(poles.one_sample(), at);
        for (std::size_t n = 0; n < samples; ++n) {
          z = multiply_add(p, z, {});
          for (const BankDrive& d : drives)
            for (std::size_t r = 0; r < kRegisters; ++r)
              z.real[r] = fma(load(d.gain[block], at + r * kWidth), all(d.force[n]), z.real[r]);
        }
        if (poles.even)
          z = multiply_add(load(poles.power[PoleBlock::kToMiddle], at), z, {});
        store(bank.state[block], at, z);
      }
    }
  }
};

} // namespace tactus::modal

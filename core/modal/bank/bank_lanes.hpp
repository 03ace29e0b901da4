#pragma once

#include "core/modal/bank/bank_tiles.hpp"

/// The loops of BankKernel, written once for any instruction set. Every function is a template on
/// the set, so that the linker never takes a newer processor's code for an older one's.
///
/// Modes lie across vector lanes. The outputs of a leap of 16 samples are products of the state at
/// its beginning with a table of the pole's powers, and the state at its end is a product of the
/// forces with the same table (block recursion of a state-space filter). No sample waits for the
/// one before, rounding enters once in 16 samples, and the pitch is as exact as the table. One
/// force and one pick-up cost 4 fused multiply-adds a mode and sample, and 10 a leap for gains and
/// the state.
///
/// Modes that share a decay cost half. With c = w z in the middle of the leap, an undamped mode
/// gives E + O at a time t after the middle and E - O at the same time before it, where
/// E = Im(c) cos(omega t) and O = Re(c) sin(omega t): one product for two samples. The common decay
/// is multiplied in afterwards. A mode's own decay may differ from it by at most
/// ModeBank::kMaxDecayMismatch; within a leap the error is that difference times 8 samples, and it
/// does not add up, because the step of the state is exact.
///
/// In both cases the output is a sum of Im(c) times the powers' real parts and of Re(c) times their
/// imaginary parts, over kLeap or kHalfLeap times (BankTiles).
namespace tactus::modal {

template <class Set> class BankLanes final : public BankKernel {
  using Tiles = BankTiles<Set>;
  using V = typename Tiles::V;
  static constexpr std::size_t kWidth = Tiles::kWidth;
  static constexpr std::size_t kRegisters = Tiles::kRegisters;
  static constexpr std::size_t kTimes = Tiles::kTimes;
  static constexpr std::uint32_t kNone = 0xffffffff; ///< no common decay

  struct Complex {
    V real, imaginary;
  };
  [[gnu::always_inline]] static Complex load(const ComplexLane& lane, std::size_t at) noexcept {
    return {Tiles::load(lane.real, at), Tiles::load(lane.imaginary, at)};
  }
  [[gnu::always_inline]] static void store(ComplexLane& lane, std::size_t at, Complex z) noexcept {
    Tiles::store(lane.real, at, z.real);
    Tiles::store(lane.imaginary, at, z.imaginary);
  }
  /// a b
  [[gnu::always_inline]] static Complex product(Complex a, Complex b) noexcept {
    return {Tiles::fma(a.real, b.real, -(a.imaginary * b.imaginary)),
            Tiles::fma(a.real, b.imaginary, a.imaginary * b.real)};
  }
  /// a b + c
  [[gnu::always_inline]] static Complex multiply_add(Complex a, Complex b, Complex c) noexcept {
    return {Tiles::fma(a.real, b.real, Tiles::fma(-a.imaginary, b.imaginary, c.real)),
            Tiles::fma(a.real, b.imaginary, Tiles::fma(a.imaginary, b.real, c.imaginary))};
  }

  /// Sums and differences of force samples that lie symmetrically about the middle of a leap, with
  /// the common decay multiplied in: the input of blocks that share a decay.
  struct Folded {
    static constexpr std::size_t kMaxDrives = 72;
    float sums[kMaxDrives][kMaxLeaps * kHalfLeap];
    float differences[kMaxDrives][kMaxLeaps * kHalfLeap];
  };
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

  /// The input of a tile's modes in leaps l to l + Leaps, before the gains: sum of p^(15 - j) F[j].
  // Seven arguments, as add_output() below: always inlined, so that they stay in registers.
  template <std::size_t Leaps>
  [[gnu::always_inline]] static void
  gather(const PoleBlock& poles, std::size_t at, const BankDrive& drive, const Folded& folded,
         std::size_t d, std::size_t l, typename Tiles::template TileSum<Leaps>& sum) noexcept {
    const bool shares_decay = poles.shares_decay;
    const float* const force = drive.force + l * kLeap;
    for (std::size_t i = 0; i < Leaps; ++i)
      for (std::size_t r = 0; r < kRegisters; ++r) {
        sum.real[i][r] = shares_decay ? V{} : Tiles::all(force[i * kLeap + kLeap - 1]); // p^0
        sum.imaginary[i][r] = V{};
      }
    if (shares_decay)
      Tiles::template gather<Leaps>(
          [&](std::size_t m) -> const ComplexLane& { return poles.power[m]; }, at, kHalfLeap,
          folded.sums[d] + l * kHalfLeap, folded.differences[d] + l * kHalfLeap, kHalfLeap, sum);
    else
      Tiles::template gather<Leaps>(
          [&](std::size_t j) -> const ComplexLane& { return poles.power[kLeap - 2 - j]; }, at,
          kLeap - 1, force, force, kLeap, sum); // p^(15 - j)
  }

  /// Stores a block's states at the beginning (or in the middle) of each leap in `states`, times
  /// `weight` if there is one, and moves the block to the end of the last leap.
  // Seven arguments: a call for a whole block of poles, whose loops take far longer than the call.
  template <std::size_t Leaps>
  [[gnu::noinline]] static void step(const BankView& bank, std::uint32_t block,
                                     std::span<const BankDrive> drives, const Folded& folded,
                                     const ComplexLane* weight, LeapPlanes& states,
                                     std::size_t b) noexcept {
    constexpr std::size_t kTile = Leaps < Tiles::kLeaps ? Leaps : Tiles::kLeaps;
    using Input = typename Tiles::template TileSum<kTile>;
    const PoleBlock& poles = bank.poles[block];
#pragma GCC unroll 1
    for (std::size_t at = 0; at < kLanes; at += Tiles::kStep)
#pragma GCC unroll 1
      for (std::size_t first = 0; first < Leaps; first += kTile) {
        Input input{};
        for (std::size_t d = 0; d < drives.size(); ++d) {
          Input sum;
          gather<kTile>(poles, at, drives[d], folded, d, first, sum);
          for (std::size_t r = 0; r < kRegisters; ++r) {
            const V gain = Tiles::load(drives[d].gain[block], at + r * kWidth);
            for (std::size_t l = 0; l < kTile; ++l) {
              input.real[l][r] = Tiles::fma(gain, sum.real[l][r], input.real[l][r]);
              input.imaginary[l][r] = Tiles::fma(gain, sum.imaginary[l][r], input.imaginary[l][r]);
            }
          }
        }
        for (std::size_t r = 0; r < kRegisters; ++r) {
          const std::size_t i = at + r * kWidth;
          const Complex leap = load(poles.whole_leap(), i);
          Complex z = load(bank.state[block], i);
          const Complex w = weight ? load(weight[block], i) : Complex{};
          for (std::size_t l = 0; l < kTile; ++l) {
            const Complex out = weight ? product(w, z) : z;
            Tiles::store(states.real[first + l][b], i, out.real);
            Tiles::store(states.imaginary[first + l][b], i, out.imaginary);
            const Complex add{input.real[l][r], input.imaginary[l][r]};
            if (poles.shares_decay)
              z = product(leap, {z.real + add.real, z.imaginary + add.imaginary});
            else
              z = multiply_add(leap, z, add);
          }
          store(bank.state[block], i, z);
        }
      }
  }

  /// weighted = weight times states.
  template <std::size_t Leaps>
  static void apply_weight(const ComplexLane& weight, const LeapPlanes& states, std::size_t b,
                           LeapPlanes& weighted) noexcept {
#pragma GCC unroll 1
    for (std::size_t at = 0; at < kLanes; at += kWidth) {
      const Complex w = load(weight, at);
      for (std::size_t l = 0; l < Leaps; ++l) {
        const Complex c = product(
            w, {Tiles::load(states.real[l][b], at), Tiles::load(states.imaginary[l][b], at)});
        Tiles::store(weighted.real[l][b], at, c.real);
        Tiles::store(weighted.imaginary[l][b], at, c.imaginary);
      }
    }
  }

  /// The two sums of one pick-up over blocks of one kind, not yet added up over their lanes.
  template <std::size_t Leaps> struct Sums {
    V real[Leaps * kLeap], imaginary[Leaps * kLeap]; // with the powers' real and imaginary parts
    void clear(std::size_t times) noexcept {
      for (std::size_t n = 0; n < Leaps * times; ++n)
        real[n] = imaginary[n] = V{};
    }
  };
  // Seven arguments: always inlined, so that they stay in registers.
  template <std::size_t Leaps, std::size_t Times>
  [[gnu::always_inline]] static void
  add_output(const PoleBlock* const* poles, std::size_t blocks, const LeapPlanes& weighted,
             std::size_t first, std::size_t times, bool from_zero, Sums<Leaps>& sums) noexcept {
    const float *real[LeapPlanes::kMaxBlocks], *imaginary[LeapPlanes::kMaxBlocks];
    for (std::size_t b = 0; b < blocks; ++b) {
      real[b] = poles[b]->power[first].real.v;
      imaginary[b] = poles[b]->power[first].imaginary.v;
    }
    Tiles::template add_output<Leaps, Times>(real, blocks, weighted.imaginary, sums.real + first,
                                             times, from_zero);
    Tiles::template add_output<Leaps, Times>(imaginary, blocks, weighted.real,
                                             sums.imaginary + first, times, from_zero);
  }

  [[gnu::always_inline]] static float after_middle(const CommonDecay& decay, std::size_t m,
                                                   float even, float odd) noexcept {
    return decay.fall[m] * (even + odd);
  }
  [[gnu::always_inline]] static float before_middle(const CommonDecay& decay, std::size_t m,
                                                    float even, float odd) noexcept {
    return decay.rise[m] * (even - odd);
  }
  /// Adds the sums over their lanes, multiplies the common decay in and adds them to the output.
  template <std::size_t Leaps>
  static void collect(const Sums<Leaps>& sums, const CommonDecay* decay, float* out) noexcept {
    const std::size_t times = decay ? kHalfLeap : kLeap, count = Leaps * times;
    alignas(64) float real[Leaps * kLeap], imaginary[Leaps * kLeap];
    for (std::size_t n = 0; n < count; n += kWidth) {
      if (count < kWidth) { // one leap in the widest registers
        for (std::size_t i = 0; i < count; ++i) {
          real[i] = Tiles::across(sums.real[i]);
          imaginary[i] = Tiles::across(sums.imaginary[i]);
        }
        break;
      }
      *reinterpret_cast<V*>(real + n) = Tiles::across(sums.real + n);
      *reinterpret_cast<V*>(imaginary + n) = Tiles::across(sums.imaginary + n);
    }
    if (!decay) {
      for (std::size_t n = 0; n < count; ++n)
        out[n] += real[n] + imaginary[n];
      return;
    }
    for (std::size_t l = 0; l < Leaps; ++l) {
      float* const middle = out + l * kLeap + kHalfLeap;
      const float* const e = real + l * kHalfLeap;
      const float* const o = imaginary + l * kHalfLeap;
      for (std::size_t m = 0; m < kHalfLeap; ++m)
        middle[m] += after_middle(*decay, m, e[m], o[m]);
      for (std::size_t m = 0; m < kHalfLeap; ++m)
        middle[-1 - static_cast<std::ptrdiff_t>(m)] += before_middle(*decay, m, e[m], o[m]);
    }
  }

  static const CommonDecay* decay_of(const BankView& bank, const PoleBlock& poles) noexcept {
    return poles.shares_decay ? &bank.decays[poles.decay_index] : nullptr;
  }

  template <std::size_t Leaps>
  static void run_leaps(const BankView& bank, std::span<const BankDrive> drives,
                        std::span<const BankPickup> pickups) noexcept {
    Sums<Leaps> sums[kMaxPickupParts];
    Folded folded;
    LeapPlanes states, weighted;
    const std::size_t pickup_count =
        pickups.size() < kMaxPickupParts ? pickups.size() : kMaxPickupParts;
    for (std::size_t k = 0; k < pickup_count; ++k)
      for (std::size_t n = 0; n < Leaps * kLeap; ++n)
        pickups[k].out[n] = 0;
    const CommonDecay* decay = nullptr;
    std::size_t times = 0; // of the sums; none yet
    bool from_zero = true; // nothing is in them
    const auto collect_all = [&] {
      for (std::size_t k = 0; k < pickup_count && times > 0; ++k)
        collect<Leaps>(sums[k], decay, pickups[k].out);
    };
    for (std::size_t n = 0; n < bank.active.size();) {
      const PoleBlock* poles[LeapPlanes::kMaxBlocks] = {&bank.poles[bank.active[n]]};
      if (const CommonDecay* const next = decay_of(bank, *poles[0]); next != decay || times == 0) {
        collect_all();
        decay = next;
        times = decay ? kHalfLeap : kLeap;
        from_zero = true;
        for (std::size_t d = 0; d < drives.size() && decay; ++d)
          fold(drives[d].force, *decay, Leaps, folded.sums[d], folded.differences[d]);
      }
      std::size_t blocks = 1;
      while (blocks < LeapPlanes::kMaxBlocks && n + blocks < bank.active.size() &&
             decay_of(bank, bank.poles[bank.active[n + blocks]]) == decay) {
        poles[blocks] = &bank.poles[bank.active[n + blocks]];
        ++blocks;
      }
      for (std::size_t b = 0; b < blocks; ++b)
        step<Leaps>(bank, bank.active[n + b], drives, folded,
                    pickup_count == 1 ? pickups[0].weight : nullptr,
                    pickup_count == 1 ? weighted : states, b);
      for (std::size_t k = 0; k < pickup_count; ++k) {
        for (std::size_t b = 0; b < blocks && pickup_count > 1; ++b)
          apply_weight<Leaps>(pickups[k].weight[bank.active[n + b]], states, b, weighted);
        for (std::size_t first = 0; first < times; first += kTimes)
          add_output<Leaps, kTimes>(poles, blocks, weighted, first, times, from_zero, sums[k]);
      }
      from_zero = false;
      n += blocks;
    }
    collect_all();
  }

public:
  void run(const BankView& bank, std::size_t leaps, std::span<const BankDrive> drives,
           std::span<const BankPickup> pickups) const noexcept override {
    if (leaps == kMaxLeaps)
      return run_leaps<kMaxLeaps>(bank, drives, pickups);
    BankDrive drive[Folded::kMaxDrives];
    BankPickup pickup[kMaxPickupParts];
    const std::size_t pickup_count =
        pickups.size() < kMaxPickupParts ? pickups.size() : kMaxPickupParts;
    for (std::size_t l = 0; l < leaps; ++l) {
      for (std::size_t d = 0; d < drives.size(); ++d)
        drive[d] = {drives[d].gain, drives[d].force + l * kLeap};
      for (std::size_t k = 0; k < pickup_count; ++k)
        pickup[k] = {pickups[k].weight, pickups[k].out + l * kLeap};
      run_leaps<1>(bank, std::span<const BankDrive>(drive, drives.size()),
                   std::span<const BankPickup>(pickup, pickup_count));
    }
  }

  void output_samples(const BankView& bank, std::size_t first, std::size_t count,
                      std::span<const BankPickup> pickups) const noexcept override {
    // The sums of run(), in the same order, for these samples alone.
    for (const BankPickup& pickup : pickups) {
      Sums<1> sums;
      LeapPlanes states, weighted;
      const CommonDecay* decay = nullptr;
      bool needed[kLeap] = {};
      std::size_t times = 0;
      for (std::size_t i = 0; i < count; ++i)
        pickup.out[i] = 0;
      const auto collect_these = [&] {
        for (std::size_t i = 0; i < count && times > 0; ++i) {
          const std::size_t n = first + i, m = time_index(n, times);
          const float re = Tiles::across(sums.real[m]), im = Tiles::across(sums.imaginary[m]);
          pickup.out[i] += !decay          ? re + im
                           : n < kHalfLeap ? before_middle(*decay, m, re, im)
                                           : after_middle(*decay, m, re, im);
        }
      };
      for (const std::uint32_t block : bank.active) {
        const PoleBlock* const poles = &bank.poles[block];
        if (const CommonDecay* const next = decay_of(bank, *poles); next != decay || times == 0) {
          collect_these();
          decay = next;
          times = decay ? kHalfLeap : kLeap;
          sums.clear(times);
          for (std::size_t m = 0; m < times; ++m)
            needed[m] = false;
          for (std::size_t i = 0; i < count; ++i)
            needed[time_index(first + i, times)] = true;
        }
        for (std::size_t at = 0; at < kLanes; at += kWidth) {
          const Complex z = load(bank.state[block], at);
          Tiles::store(states.real[0][0], at, z.real);
          Tiles::store(states.imaginary[0][0], at, z.imaginary);
        }
        apply_weight<1>(pickup.weight[block], states, 0, weighted);
        for (std::size_t m = 0; m < times; ++m)
          if (needed[m])
            add_output<1, 1>(&poles, 1, weighted, m, times, false, sums);
      }
      collect_these();
    }
  }

  void feedthrough(const float* force, const float* response, std::size_t leaps,
                   float* out) const noexcept override {
    std::size_t l = 0;
    for (; l + kMaxLeaps <= leaps; l += kMaxLeaps)
      feedthrough_of<kMaxLeaps>(force + l * kLeap, response, out + l * kLeap);
    for (; l < leaps; ++l)
      feedthrough_of<1>(force + l * kLeap, response, out + l * kLeap);
  }

  void impulse_response(const PoleBlock* poles, const Lane* gain, const ComplexLane* weight,
                        std::size_t blocks, float* out) const noexcept override {
    V sum[kLeap] = {};
    for (std::size_t b = 0; b < blocks; ++b)
      for (std::size_t at = 0; at < kLanes; at += kWidth) {
        const Complex p = load(poles[b].one_sample(), at), w = load(weight[b], at);
        const V size = Tiles::load(gain[b], at);
        Complex z{w.real * size, w.imaginary * size};
#pragma GCC unroll 1
        for (std::size_t m = 0; m < kLeap; ++m) {
          sum[m] += z.imaginary;
          z = product(p, z);
        }
      }
    for (std::size_t m = 0; m < kLeap; ++m)
      out[m] = Tiles::across(sum[m]);
  }

  void accumulate(const float* a, const float* b, float* c, std::size_t rows, std::size_t inner,
                  std::size_t columns) const noexcept override {
    std::size_t r = 0;
    for (; r + kTileRows <= rows; r += kTileRows)
      accumulate_rows<kTileRows>(a + r * inner, b, c + r * columns, inner, columns);
    for (; r < rows; ++r)
      accumulate_rows<1>(a + r * inner, b, c + r * columns, inner, columns);
  }

  void advance(const BankView& bank, std::size_t samples,
               std::span<const BankDrive> drives) const noexcept override {
    Folded folded;
    LeapPlanes unused;
    for (const std::uint32_t block : bank.active) {
      const PoleBlock& poles = bank.poles[block];
      if (samples == kLeap) {
        if (poles.shares_decay)
          for (std::size_t d = 0; d < drives.size(); ++d)
            fold(drives[d].force, bank.decays[poles.decay_index], 1, folded.sums[d],
                 folded.differences[d]);
        step<1>(bank, block, drives, folded, nullptr, unused, 0);
        continue;
      }
      for (std::size_t at = 0; at < kLanes; at += kWidth) {
        Complex z = load(bank.state[block], at);
        if (poles.shares_decay)
          z = product(load(poles.power[PoleBlock::kFromMiddle], at), z);
        const Complex p = load(poles.one_sample(), at);
        for (std::size_t n = 0; n < samples; ++n) {
          z = product(p, z);
          for (const BankDrive& d : drives)
            z.real = Tiles::fma(Tiles::load(d.gain[block], at), Tiles::all(d.force[n]), z.real);
        }
        if (poles.shares_decay)
          z = product(load(poles.power[PoleBlock::kToMiddle], at), z);
        store(bank.state[block], at, z);
      }
    }
  }

private:
  using Unaligned [[gnu::vector_size(sizeof(V)), gnu::aligned(4), gnu::may_alias]] = float;
  static constexpr std::size_t kTileRows = 4;
  template <std::size_t Rows>
  static void accumulate_rows(const float* a, const float* b, float* c, std::size_t inner,
                              std::size_t columns) noexcept {
    constexpr std::size_t kVectors = kLeap / kWidth < 2 ? 1 : 2;
    for (std::size_t n = 0; n < columns; n += kVectors * kWidth) {
      V sum[Rows][kVectors];
      for (std::size_t r = 0; r < Rows; ++r)
        for (std::size_t i = 0; i < kVectors; ++i)
          sum[r][i] = *reinterpret_cast<const Unaligned*>(c + r * columns + n + i * kWidth);
#pragma GCC unroll 1
      for (std::size_t k = 0; k < inner; ++k) {
        V right[kVectors];
        for (std::size_t i = 0; i < kVectors; ++i)
          right[i] = *reinterpret_cast<const Unaligned*>(b + k * columns + n + i * kWidth);
#pragma GCC unroll 4
        for (std::size_t r = 0; r < Rows; ++r)
          for (std::size_t i = 0; i < kVectors; ++i)
            sum[r][i] = Tiles::fma(Tiles::all(a[r * inner + k]), right[i], sum[r][i]);
      }
      for (std::size_t r = 0; r < Rows; ++r)
        for (std::size_t i = 0; i < kVectors; ++i)
          *reinterpret_cast<Unaligned*>(c + r * columns + n + i * kWidth) = sum[r][i];
    }
  }

  template <std::size_t Leaps>
  static void feedthrough_of(const float* force, const float* response, float* out) noexcept {
    constexpr std::size_t kParts = kLeap / kWidth;
#pragma GCC unroll 1
    for (std::size_t part = 0; part < kParts; ++part) {
      const float* const from = response + kLeap + part * kWidth;
      V sum[Leaps];
      for (std::size_t l = 0; l < Leaps; ++l)
        sum[l] = V{};
#pragma GCC unroll 1
      for (std::size_t j = 0; j < kLeap; ++j) {
        const V row = *reinterpret_cast<const Unaligned*>(from - j);
        for (std::size_t l = 0; l < Leaps; ++l)
          sum[l] = Tiles::fma(Tiles::all(force[l * kLeap + j]), row, sum[l]);
      }
      for (std::size_t l = 0; l < Leaps; ++l)
        *reinterpret_cast<Unaligned*>(out + l * kLeap + part * kWidth) += sum[l];
    }
  }
  /// The index in the sums of sample n of a leap.
  static std::size_t time_index(std::size_t n, std::size_t times) noexcept {
    return times == kLeap ? n : n < kHalfLeap ? kHalfLeap - 1 - n : n - kHalfLeap;
  }
};

} // namespace tactus::modal

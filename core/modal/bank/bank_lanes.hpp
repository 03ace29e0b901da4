#pragma once

#include "core/modal/bank/bank_tiles.hpp"

/// The loops of BankKernel, written once for any instruction set. Every function is a template on
/// the set, so that the linker cannot use code for a newer processor in place of code for an older
/// one.
///
/// Modes lie across vector lanes. The outputs of a time block of 16 samples are products of the
/// state at its beginning with a table of the pole's powers. The state at its end is a product of
/// the forces with the same table (block recursion of a state-space filter). No sample waits for
/// the one before, rounding enters once in 16 samples, and the pitch is as exact as the table. One
/// force and one pick-up cost 4 fused multiply-adds per mode and sample, and 10 per mode and time
/// block for gains and the state.
///
/// Modes that share a decay cost half. With c = w z in the middle of the time block, an undamped
/// mode gives E + O at a time t after the middle and E - O at the same time before it. E = Im(c)
/// cos(omega t) and O = Re(c) sin(omega t), so one product serves two samples. The common decay is
/// multiplied in afterwards. A mode's own decay may differ from it by at most
/// ModeBank::kMaxDecayMismatch. Within a time block the error is that difference times 8 samples.
/// It does not accumulate, because the step of the state is exact.
///
/// In both cases the output is a sum of Im(c) times the powers' real parts and of Re(c) times their
/// imaginary parts, over kTimeBlock or kHalfTimeBlock times (BankTiles).
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

  /// Sums and differences of force samples that lie symmetrically about the middle of a time block,
  /// with the common decay multiplied in: the input of blocks that share a decay.
  struct Folded {
    static constexpr std::size_t kMaxDrives = 72;
    float sums[kMaxDrives][kMaxTimeBlocks * kHalfTimeBlock];
    float differences[kMaxDrives][kMaxTimeBlocks * kHalfTimeBlock];
  };
  static void fold(const float* force, const CommonDecay& decay, std::size_t time_blocks,
                   float* sums, float* differences) noexcept {
    for (std::size_t l = 0; l < time_blocks; ++l)
      for (std::size_t m = 0; m < kHalfTimeBlock; ++m) {
        const float before = force[l * kTimeBlock + kHalfTimeBlock - 1 - m] * decay.fall[m];
        const float after = force[l * kTimeBlock + kHalfTimeBlock + m] * decay.rise[m];
        sums[l * kHalfTimeBlock + m] = before + after;
        differences[l * kHalfTimeBlock + m] = before - after;
      }
  }

  /// The input of a tile's modes in time blocks from l on, before the gains: sum of p^(15 - j)
  /// F[j].
  // Always inlined, as add_output() below, so that the seven arguments stay in registers.
  template <std::size_t TimeBlocks>
  [[gnu::always_inline]] static void
  gather(const PoleBlock& poles, std::size_t at, const BankDrive& drive, const Folded& folded,
         std::size_t d, std::size_t l, typename Tiles::template TileSum<TimeBlocks>& sum) noexcept {
    const bool shares_decay = poles.shares_decay;
    const float* const force = drive.force + l * kTimeBlock;
    for (std::size_t i = 0; i < TimeBlocks; ++i)
      for (std::size_t r = 0; r < kRegisters; ++r) {
        sum.real[i][r] =
            shares_decay ? V{} : Tiles::all(force[i * kTimeBlock + kTimeBlock - 1]); // p^0
        sum.imaginary[i][r] = V{};
      }
    if (shares_decay)
      Tiles::template gather<TimeBlocks>(
          [&](std::size_t m) -> const ComplexLane& { return poles.power[m]; }, at, kHalfTimeBlock,
          folded.sums[d] + l * kHalfTimeBlock, folded.differences[d] + l * kHalfTimeBlock,
          kHalfTimeBlock, sum);
    else
      Tiles::template gather<TimeBlocks>(
          [&](std::size_t j) -> const ComplexLane& { return poles.power[kTimeBlock - 2 - j]; }, at,
          kTimeBlock - 1, force, force, kTimeBlock, sum); // p^(15 - j)
  }

  /// Stores a block's states at the beginning (or in the middle) of each time block in `states`,
  /// times `weight` if there is one, and advances the block to the end of the last time block.
  // Not inlined: the loops over a whole block of poles take far longer than a call with seven
  // arguments.
  template <std::size_t TimeBlocks>
  [[gnu::noinline]] static void step(const BankView& bank, std::uint32_t block,
                                     std::span<const BankDrive> drives, const Folded& folded,
                                     const ComplexLane* weight, TimeBlockPlanes& states,
                                     std::size_t b) noexcept {
    constexpr std::size_t kTile = TimeBlocks < Tiles::kTimeBlocks ? TimeBlocks : Tiles::kTimeBlocks;
    using Input = typename Tiles::template TileSum<kTile>;
    const PoleBlock& poles = bank.poles[block];
#pragma GCC unroll 1
    for (std::size_t at = 0; at < kLanes; at += Tiles::kStep)
#pragma GCC unroll 1
      for (std::size_t first = 0; first < TimeBlocks; first += kTile) {
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
          const Complex block_pole = load(poles.whole_time_block(), i);
          Complex z = load(bank.state[block], i);
          const Complex w = weight ? load(weight[block], i) : Complex{};
          for (std::size_t l = 0; l < kTile; ++l) {
            const Complex out = weight ? product(w, z) : z;
            Tiles::store(states.real[first + l][b], i, out.real);
            Tiles::store(states.imaginary[first + l][b], i, out.imaginary);
            const Complex add{input.real[l][r], input.imaginary[l][r]};
            if (poles.shares_decay)
              z = product(block_pole, {z.real + add.real, z.imaginary + add.imaginary});
            else
              z = multiply_add(block_pole, z, add);
          }
          store(bank.state[block], i, z);
        }
      }
  }

  /// weighted = weight times states.
  template <std::size_t TimeBlocks>
  static void apply_weight(const ComplexLane& weight, const TimeBlockPlanes& states, std::size_t b,
                           TimeBlockPlanes& weighted) noexcept {
#pragma GCC unroll 1
    for (std::size_t at = 0; at < kLanes; at += kWidth) {
      const Complex w = load(weight, at);
      for (std::size_t l = 0; l < TimeBlocks; ++l) {
        const Complex c = product(
            w, {Tiles::load(states.real[l][b], at), Tiles::load(states.imaginary[l][b], at)});
        Tiles::store(weighted.real[l][b], at, c.real);
        Tiles::store(weighted.imaginary[l][b], at, c.imaginary);
      }
    }
  }

  /// The two sums of one pick-up over blocks of one kind, not yet added up over their lanes.
  template <std::size_t TimeBlocks> struct Sums {
    V real[TimeBlocks * kTimeBlock],
        imaginary[TimeBlocks * kTimeBlock]; // sums with the powers' real and imaginary parts
    void clear(std::size_t times) noexcept {
      for (std::size_t n = 0; n < TimeBlocks * times; ++n)
        real[n] = imaginary[n] = V{};
    }
  };
  // Always inlined, so that the seven arguments stay in registers.
  template <std::size_t TimeBlocks, std::size_t Times>
  [[gnu::always_inline]] static void add_output(const PoleBlock* const* poles, std::size_t blocks,
                                                const TimeBlockPlanes& weighted, std::size_t first,
                                                std::size_t times, bool from_zero,
                                                Sums<TimeBlocks>& sums) noexcept {
    const float *real[TimeBlockPlanes::kMaxBlocks], *imaginary[TimeBlockPlanes::kMaxBlocks];
    for (std::size_t b = 0; b < blocks; ++b) {
      real[b] = poles[b]->power[first].real.v;
      imaginary[b] = poles[b]->power[first].imaginary.v;
    }
    Tiles::template add_output<TimeBlocks, Times>(real, blocks, weighted.imaginary,
                                                  sums.real + first, times, from_zero);
    Tiles::template add_output<TimeBlocks, Times>(imaginary, blocks, weighted.real,
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
  /// Adds up the sums over their lanes, multiplies by the common decay and adds to the output.
  template <std::size_t TimeBlocks>
  static void collect(const Sums<TimeBlocks>& sums, const CommonDecay* decay, float* out) noexcept {
    const std::size_t times = decay ? kHalfTimeBlock : kTimeBlock, count = TimeBlocks * times;
    alignas(64) float real[TimeBlocks * kTimeBlock], imaginary[TimeBlocks * kTimeBlock];
    for (std::size_t n = 0; n < count; n += kWidth) {
      if (count < kWidth) { // one time block in the widest registers
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
    for (std::size_t l = 0; l < TimeBlocks; ++l) {
      float* const middle = out + l * kTimeBlock + kHalfTimeBlock;
      const float* const e = real + l * kHalfTimeBlock;
      const float* const o = imaginary + l * kHalfTimeBlock;
      for (std::size_t m = 0; m < kHalfTimeBlock; ++m)
        middle[m] += after_middle(*decay, m, e[m], o[m]);
      for (std::size_t m = 0; m < kHalfTimeBlock; ++m)
        middle[-1 - static_cast<std::ptrdiff_t>(m)] += before_middle(*decay, m, e[m], o[m]);
    }
  }

  static const CommonDecay* decay_of(const BankView& bank, const PoleBlock& poles) noexcept {
    return poles.shares_decay ? &bank.decays[poles.decay_index] : nullptr;
  }

  template <std::size_t TimeBlocks>
  static void run_time_blocks(const BankView& bank, std::span<const BankDrive> drives,
                              std::span<const BankPickup> pickups) noexcept {
    Sums<TimeBlocks> sums[kMaxPickupParts];
    Folded folded;
    TimeBlockPlanes states, weighted;
    const std::size_t pickup_count =
        pickups.size() < kMaxPickupParts ? pickups.size() : kMaxPickupParts;
    for (std::size_t k = 0; k < pickup_count; ++k)
      for (std::size_t n = 0; n < TimeBlocks * kTimeBlock; ++n)
        pickups[k].out[n] = 0;
    const CommonDecay* decay = nullptr;
    std::size_t times = 0; // number of times in the sums; 0: no sums yet
    bool from_zero = true; // the sums are still empty
    const auto collect_all = [&] {
      for (std::size_t k = 0; k < pickup_count && times > 0; ++k)
        collect<TimeBlocks>(sums[k], decay, pickups[k].out);
    };
    for (std::size_t n = 0; n < bank.active.size();) {
      const PoleBlock* poles[TimeBlockPlanes::kMaxBlocks] = {&bank.poles[bank.active[n]]};
      if (const CommonDecay* const next = decay_of(bank, *poles[0]); next != decay || times == 0) {
        collect_all();
        decay = next;
        times = decay ? kHalfTimeBlock : kTimeBlock;
        from_zero = true;
        for (std::size_t d = 0; d < drives.size() && decay; ++d)
          fold(drives[d].force, *decay, TimeBlocks, folded.sums[d], folded.differences[d]);
      }
      std::size_t blocks = 1;
      while (blocks < TimeBlockPlanes::kMaxBlocks && n + blocks < bank.active.size() &&
             decay_of(bank, bank.poles[bank.active[n + blocks]]) == decay) {
        poles[blocks] = &bank.poles[bank.active[n + blocks]];
        ++blocks;
      }
      for (std::size_t b = 0; b < blocks; ++b)
        step<TimeBlocks>(bank, bank.active[n + b], drives, folded,
                         pickup_count == 1 ? pickups[0].weight : nullptr,
                         pickup_count == 1 ? weighted : states, b);
      for (std::size_t k = 0; k < pickup_count; ++k) {
        for (std::size_t b = 0; b < blocks && pickup_count > 1; ++b)
          apply_weight<TimeBlocks>(pickups[k].weight[bank.active[n + b]], states, b, weighted);
        for (std::size_t first = 0; first < times; first += kTimes)
          add_output<TimeBlocks, kTimes>(poles, blocks, weighted, first, times, from_zero, sums[k]);
      }
      from_zero = false;
      n += blocks;
    }
    collect_all();
  }

public:
  void run(const BankView& bank, std::size_t time_blocks, std::span<const BankDrive> drives,
           std::span<const BankPickup> pickups) const noexcept override {
    if (time_blocks == kMaxTimeBlocks)
      return run_time_blocks<kMaxTimeBlocks>(bank, drives, pickups);
    BankDrive drive[Folded::kMaxDrives];
    BankPickup pickup[kMaxPickupParts];
    const std::size_t pickup_count =
        pickups.size() < kMaxPickupParts ? pickups.size() : kMaxPickupParts;
    for (std::size_t l = 0; l < time_blocks; ++l) {
      for (std::size_t d = 0; d < drives.size(); ++d)
        drive[d] = {drives[d].gain, drives[d].force + l * kTimeBlock};
      for (std::size_t k = 0; k < pickup_count; ++k)
        pickup[k] = {pickups[k].weight, pickups[k].out + l * kTimeBlock};
      run_time_blocks<1>(bank, std::span<const BankDrive>(drive, drives.size()),
                         std::span<const BankPickup>(pickup, pickup_count));
    }
  }

  void output_samples(const BankView& bank, std::size_t first, std::size_t count,
                      std::span<const BankPickup> pickups) const noexcept override {
    // The sums of run(), in the same order, for these samples alone.
    for (const BankPickup& pickup : pickups) {
      Sums<1> sums;
      TimeBlockPlanes states, weighted;
      const CommonDecay* decay = nullptr;
      bool needed[kTimeBlock] = {};
      std::size_t times = 0;
      for (std::size_t i = 0; i < count; ++i)
        pickup.out[i] = 0;
      const auto collect_these = [&] {
        for (std::size_t i = 0; i < count && times > 0; ++i) {
          const std::size_t n = first + i, m = time_index(n, times);
          const float re = Tiles::across(sums.real[m]), im = Tiles::across(sums.imaginary[m]);
          pickup.out[i] += !decay               ? re + im
                           : n < kHalfTimeBlock ? before_middle(*decay, m, re, im)
                                                : after_middle(*decay, m, re, im);
        }
      };
      for (const std::uint32_t block : bank.active) {
        const PoleBlock* const poles = &bank.poles[block];
        if (const CommonDecay* const next = decay_of(bank, *poles); next != decay || times == 0) {
          collect_these();
          decay = next;
          times = decay ? kHalfTimeBlock : kTimeBlock;
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

  void feedthrough(const float* force, const float* response, std::size_t time_blocks,
                   float* out) const noexcept override {
    std::size_t l = 0;
    for (; l + kMaxTimeBlocks <= time_blocks; l += kMaxTimeBlocks)
      feedthrough_of<kMaxTimeBlocks>(force + l * kTimeBlock, response, out + l * kTimeBlock);
    for (; l < time_blocks; ++l)
      feedthrough_of<1>(force + l * kTimeBlock, response, out + l * kTimeBlock);
  }

  void impulse_response(const PoleBlock* poles, const Lane* gain, const ComplexLane* weight,
                        std::size_t blocks, float* out) const noexcept override {
    V sum[kTimeBlock] = {};
    for (std::size_t b = 0; b < blocks; ++b)
      for (std::size_t at = 0; at < kLanes; at += kWidth) {
        const Complex p = load(poles[b].one_sample(), at), w = load(weight[b], at);
        const V size = Tiles::load(gain[b], at);
        Complex z{w.real * size, w.imaginary * size};
#pragma GCC unroll 1
        for (std::size_t m = 0; m < kTimeBlock; ++m) {
          sum[m] += z.imaginary;
          z = product(p, z);
        }
      }
    for (std::size_t m = 0; m < kTimeBlock; ++m)
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
    TimeBlockPlanes unused;
    for (const std::uint32_t block : bank.active) {
      const PoleBlock& poles = bank.poles[block];
      if (samples == kTimeBlock) {
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
    constexpr std::size_t kVectors = kTimeBlock / kWidth < 2 ? 1 : 2;
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

  template <std::size_t TimeBlocks>
  static void feedthrough_of(const float* force, const float* response, float* out) noexcept {
    constexpr std::size_t kParts = kTimeBlock / kWidth;
#pragma GCC unroll 1
    for (std::size_t part = 0; part < kParts; ++part) {
      const float* const from = response + kTimeBlock + part * kWidth;
      V sum[TimeBlocks];
      for (std::size_t l = 0; l < TimeBlocks; ++l)
        sum[l] = V{};
#pragma GCC unroll 1
      for (std::size_t j = 0; j < kTimeBlock; ++j) {
        const V row = *reinterpret_cast<const Unaligned*>(from - j);
        for (std::size_t l = 0; l < TimeBlocks; ++l)
          sum[l] = Tiles::fma(Tiles::all(force[l * kTimeBlock + j]), row, sum[l]);
      }
      for (std::size_t l = 0; l < TimeBlocks; ++l)
        *reinterpret_cast<Unaligned*>(out + l * kTimeBlock + part * kWidth) += sum[l];
    }
  }
  /// The index in the sums of sample n of a time block.
  static std::size_t time_index(std::size_t n, std::size_t times) noexcept {
    return times == kTimeBlock  ? n
           : n < kHalfTimeBlock ? kHalfTimeBlock - 1 - n
                                : n - kHalfTimeBlock;
  }
};

} // namespace tactus::modal

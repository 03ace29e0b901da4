#pragma once

#include "core/dsp/simd.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

/// The interface to the inner loops of the mode bank. Each instruction set has its own copy of
/// them.
///
/// The bank computes modes in blocks of kLanes and time in blocks of kTimeBlock samples ("time
/// blocks"). A time block is one step of a block state-space recursion: one complex state per mode
/// at its beginning gives all its samples, and one product by p^kTimeBlock gives the next state.
namespace tactus::modal {

inline constexpr std::size_t kLanes = 64;     ///< modes in a block
inline constexpr std::size_t kTimeBlock = 16; ///< samples in a time block
inline constexpr std::size_t kHalfTimeBlock = kTimeBlock / 2;
inline constexpr std::size_t kMaxTimeBlocks = 4; ///< time blocks in one call
inline constexpr std::size_t kMaxSamples = kTimeBlock * kMaxTimeBlocks;
inline constexpr std::size_t kMaxPickupParts = 12; ///< pick-ups in one call

/// One real number for each mode of a block.
struct alignas(64) Lane {
  float v[kLanes];
};
struct alignas(64) ComplexLane {
  Lane real, imaginary;
};

/// The poles p = exp(s T) of a block of modes, s their rates in 1/s and T a sample's length.
///
/// Where the decays differ, power[m] holds p^(m + 1). Where the modes share a decay (shares_decay),
/// power[m], m < kHalfTimeBlock, holds cos and sin of omega T (m + 1/2). The entries at the indices
/// below hold the powers that move a state between the beginning and the middle of a time block.
struct alignas(64) PoleBlock {
  ComplexLane power[kTimeBlock];
  bool shares_decay = false;
  std::uint32_t decay_index = 0; ///< index in BankView::decays, if shares_decay

  static constexpr std::size_t kWholeTimeBlock = 8, kToMiddle = 9, kFromMiddle = 10,
                               kOneSample = 11;
  [[nodiscard]] const ComplexLane& whole_time_block() const noexcept {
    return power[shares_decay ? kWholeTimeBlock : kTimeBlock - 1];
  }
  [[nodiscard]] const ComplexLane& one_sample() const noexcept {
    return power[shares_decay ? kOneSample : 0];
  }
};
/// exp(-alpha T (m + 1/2)) and its inverse, for the alpha that several blocks share.
struct CommonDecay {
  float fall[kHalfTimeBlock], rise[kHalfTimeBlock];
};

/// The data of a bank that a kernel works on. The state z of a mode follows z[n] = p z[n-1] + b T
/// F[n], and the output of a pick-up with complex weight w is the sum of Im(w z) over the modes.
/// Blocks with shares_decay store p^8.5 z, the state in the middle of the next time block. Blocks
/// that are not listed as active hold zeros and are skipped.
struct BankView {
  const PoleBlock* poles = nullptr;
  const CommonDecay* decays = nullptr;
  ComplexLane* state = nullptr;
  std::span<const std::uint32_t> active;
};
/// Samples of one force in N, and the modes' gains b T at the point where it acts.
struct BankDrive {
  const Lane* gain = nullptr;
  const float* force = nullptr;
};
/// Complex weights w of all modes, and the samples of the output.
struct BankPickup {
  const ComplexLane* weight = nullptr;
  float* out = nullptr; ///< overwritten
};

class BankKernel {
public:
  virtual ~BankKernel() = default;
  /// Computes whole time blocks: the output of the states at the beginning of each time block, and
  /// the states after the last. Forces change the states; feedthrough() adds their output within
  /// their own time block.
  virtual void run(const BankView&, std::size_t time_blocks, std::span<const BankDrive>,
                   std::span<const BankPickup>) const noexcept = 0;
  /// The outputs of samples `first` to `first + count` of one time block. Does not change the
  /// states.
  virtual void output_samples(const BankView&, std::size_t first, std::size_t count,
                              std::span<const BankPickup>) const noexcept = 0;
  /// Advances the states by `samples` <= kTimeBlock under the forces, from the start of a time
  /// block.
  virtual void advance(const BankView&, std::size_t samples,
                       std::span<const BankDrive>) const noexcept = 0;
  /// Adds the output of forces within their own time block (the direct term of a state-space
  /// model): out[i] += sum over j <= i of force[j] response[kTimeBlock + i - j], for each of
  /// `time_blocks`. `response` has 2 kTimeBlock entries: kTimeBlock zeros, then impulse_response().
  virtual void feedthrough(const float* force, const float* response, std::size_t time_blocks,
                           float* out) const noexcept = 0;
  /// The output within a time block for a force of 1 N at its first sample: out[m] = sum over the
  /// modes of all `blocks` of Im(w b T p^m), m = 0 ... kTimeBlock - 1.
  virtual void impulse_response(const PoleBlock* poles, const Lane* gain, const ComplexLane* weight,
                                std::size_t blocks, float* out) const noexcept = 0;
  /// c += a b, matrices row by row: a [rows][inner], b [inner][columns], c [rows][columns];
  /// `columns` a multiple of kTimeBlock.
  virtual void accumulate(const float* a, const float* b, float* c, std::size_t rows,
                          std::size_t inner, std::size_t columns) const noexcept = 0;
};

using simd::VectorSet;
/// The implementation for the widest instruction set that the processor supports, up to `widest`.
[[nodiscard]] const BankKernel* bank_kernel(VectorSet widest) noexcept;
[[nodiscard]] const BankKernel* bank_kernel(simd::Baseline) noexcept;
[[nodiscard]] const BankKernel* bank_kernel(simd::Avx2) noexcept;
[[nodiscard]] const BankKernel* bank_kernel(simd::Avx512) noexcept;

} // namespace tactus::modal

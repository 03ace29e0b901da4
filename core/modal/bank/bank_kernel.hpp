#pragma once

#include "core/dsp/simd.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

/// The inner loops of the mode bank, one copy for each instruction set.
namespace tactus::modal {

inline constexpr std::size_t kLanes = 64; ///< modes that are computed together
inline constexpr std::size_t kLeap = 16;  ///< samples from one state to the next
inline constexpr std::size_t kHalfLeap = kLeap / 2;
inline constexpr std::size_t kMaxLeaps = 4; ///< in one call
inline constexpr std::size_t kMaxSamples = kLeap * kMaxLeaps;
inline constexpr std::size_t kMaxPickupParts = 12; ///< pick-ups in one call

/// One number of each of kLanes modes.
struct alignas(64) Lane {
  float v[kLanes];
};
struct alignas(64) ComplexLane {
  Lane real, imaginary;
};

/// A block of modes whose decays differ, with the powers p, p^2 ... p^16 of the poles
/// p = exp(s T); or, where `even` is set, a block of modes that decay alike, in another order:
/// cos and sin of omega T (m + 1/2), then at the indices below some powers of the poles.
struct alignas(64) PoleBlock {
  ComplexLane power[kLeap];
  bool even = false;
  std::uint32_t decay = 0; ///< of an even block: which of the bank's common decays

  static constexpr std::size_t kWholeLeap = 8, kToMiddle = 9, kFromMiddle = 10, kOneSample = 11;
  [[nodiscard]] const ComplexLane& whole_leap() const noexcept {
    return power[even ? kWholeLeap : kLeap - 1];
  }
  [[nodiscard]] const ComplexLane& one_sample() const noexcept {
    return power[even ? kOneSample : 0];
  }
};
/// exp(-alpha T (m + 1/2)) and its inverse, for the alpha that a group of even blocks shares.
struct CommonDecay {
  float fall[kHalfLeap], rise[kHalfLeap];
};

/// What a kernel works on. The state z of a mode follows z[n] = p z[n-1] + b T F[n]; a pick-up with
/// complex weight w hears Im(w z). Even blocks hold p^(8.5) z, the state in the middle of the leap
/// to come. Blocks that are not listed as active hold zeros and are skipped.
struct BankView {
  const PoleBlock* poles = nullptr;
  const CommonDecay* decays = nullptr;
  ComplexLane* state = nullptr;
  std::span<const std::uint32_t> active;
};
/// Samples of one force, and the modes' gains b T at its place.
struct BankDrive {
  const Lane* gain = nullptr;
  const float* force = nullptr;
};
struct BankPickup {
  const ComplexLane* weight = nullptr;
  float* out = nullptr; ///< overwritten
};

class BankKernel {
public:
  virtual ~BankKernel() = default;
  /// Whole leaps: what the pick-ups hear of the states at their beginnings, without the forces of
  /// the leap itself, and the states after them.
  virtual void run(const BankView&, std::size_t leaps, std::span<const BankDrive>,
                   std::span<const BankPickup>) const noexcept = 0;
  /// Samples `first` to `first + count` of one leap only; the state stays.
  virtual void listen(const BankView&, std::size_t first, std::size_t count,
                      std::span<const BankPickup>) const noexcept = 0;
  /// The state after the first `samples` <= kLeap of a leap, from the forces in that time.
  virtual void advance(const BankView&, std::size_t samples,
                       std::span<const BankDrive>) const noexcept = 0;
  /// out[i] += sum over j <= i of force[j] response[kLeap + i - j], leap by leap; response is zero
  /// below kLeap.
  virtual void echo(const float* force, const float* response, std::size_t leaps,
                    float* out) const noexcept = 0;
  /// What is heard within a leap of a unit force at its beginning: out[m] = sum over the modes of
  /// all `blocks` of Im(w b T p^m), m = 0 ... kLeap - 1.
  virtual void impulse_response(const PoleBlock* poles, const Lane* gain, const ComplexLane* weight,
                                std::size_t blocks, float* out) const noexcept = 0;
  /// c += a b, matrices row by row: a [rows][inner], b [inner][columns], c [rows][columns];
  /// `columns` a multiple of kLeap.
  virtual void accumulate(const float* a, const float* b, float* c, std::size_t rows,
                          std::size_t inner, std::size_t columns) const noexcept = 0;
};

enum class VectorSet { kBaseline, kAvx2, kAvx512 };
/// The widest that this processor runs.
[[nodiscard]] VectorSet best_vector_set() noexcept;
/// Null where the processor does not run it.
[[nodiscard]] const BankKernel* bank_kernel(VectorSet) noexcept;

} // namespace tactus::modal

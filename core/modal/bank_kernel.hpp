#pragma once

#include "core/dsp/simd.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

/// The inner loops of the mode bank, one copy for each instruction set.
namespace tactus::modal {

inline constexpr std::size_t kLanes = 32;      ///< modes that are computed together
inline constexpr std::size_t kLeap = 8;        ///< samples from one state to the next
inline constexpr std::size_t kMostLeaps = 8;   ///< in one call
inline constexpr std::size_t kMostSamples = kLeap * kMostLeaps;

inline constexpr std::size_t kMostEars = 8;    ///< pick-ups in one call

/// One number of each of kLanes modes.
struct alignas(64) Lane {
  float v[kLanes];
};

/// A block of modes: the powers p, p^2 ... p^8 of the poles p = exp(s T), real parts then imaginary.
struct alignas(64) PoleBlock {
  Lane real[kLeap], imaginary[kLeap];
};
struct alignas(64) ComplexLane {
  Lane real, imaginary;
};

/// What a kernel works on. The state z of a mode follows z[n] = p z[n-1] + b T F[n]; a pick-up with
/// complex weight w hears Im(w z). Blocks that are not listed as active hold zeros and are skipped.
struct BankView {
  const PoleBlock* poles = nullptr;
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
  /// The state after `samples` <= kLeap samples of a leap, from the forces in that time.
  virtual void advance(const BankView&, std::size_t samples,
                       std::span<const BankDrive>) const noexcept = 0;
};

enum class VectorSet { kBaseline, kAvx2, kAvx512 };
/// The widest that this processor runs.
[[nodiscard]] VectorSet best_vector_set() noexcept;
/// Null where the processor does not run it.
[[nodiscard]] const BankKernel* bank_kernel(VectorSet) noexcept;

} // namespace tactus::modal

#pragma once

#include "core/reed/bore/woodwind.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace tactus::reed {

/// Computes the Termination for any state of the tone holes, closed[i] from the reed down (1
/// closed, 0 open, in between partly covered).
///
/// The response beyond the first open hole comes from transfer matrices (HoleLattice) and is
/// approximated by poles (fit_poles), scaled so that |R| <= 1 at every frequency. It takes some
/// milliseconds, about the same for every state, and allocates nothing. If no poles are found, it
/// returns false and leaves `fingering` unchanged.
[[nodiscard]] bool finger_holes(const Woodwind& instrument, std::span<const double> closed,
                                Termination& fingering) noexcept;

/// Cache of the last kSize results of finger_holes(), so that trills cost nothing. A result stays
/// at its address until kSize others have been used since.
class HoleFingerings {
public:
  static constexpr std::size_t kSize = 32;

  /// Finds or computes a fingering of the woodwind `end`. Null for other ends, another number of
  /// holes, or if finger_holes() returns false.
  [[nodiscard]] const Termination* find(BoreEnd end, std::span<const double> closed) noexcept;

private:
  struct CacheEntry {
    BoreEnd end = BoreEnd::kOpen;
    std::array<double, Woodwind::kMaxToneHoles> closed{};
    Termination fingering{};
    unsigned long last_use = 0; // value of use_count_; 0: never
  };
  std::array<CacheEntry, kSize> entries_{};
  unsigned long use_count_ = 0;
};

} // namespace tactus::reed

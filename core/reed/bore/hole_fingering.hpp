#pragma once

#include "core/reed/bore/woodwind.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace tactus::reed {

/// The fingering of any state of the tone holes, closed[i] from the reed down (1 closed, 0 open, in
/// between partly covered): transfer matrices of what lies beyond the first open hole
/// (HoleLattice), approximated by poles (fit_poles) and |R| <= 1 at every frequency. Takes some
/// milliseconds, the same for every state; allocates nothing. False where no poles are found.
[[nodiscard]] bool finger_holes(const Woodwind& instrument, std::span<const double> closed,
                                Termination& fingering) noexcept;

/// Fingerings that have been asked for, kept: a trill finds both of its own here. They stay where
/// they are until kSize others have been asked for since.
class HoleFingerings {
public:
  static constexpr std::size_t kSize = 32;

  /// Null where there is none: finger_holes() says when.
  [[nodiscard]] const Termination* find(BoreEnd end, std::span<const double> closed) noexcept;

private:
  struct CacheEntry {
    BoreEnd end = BoreEnd::kOpen;
    std::array<double, Woodwind::kMaxToneHoles> closed{};
    Termination fingering{};
    unsigned long last_use = 0; // when last; 0: never
  };
  std::array<CacheEntry, kSize> entries_{};
  unsigned long use_count_ = 0;
};

} // namespace tactus::reed

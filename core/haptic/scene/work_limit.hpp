#pragma once

#include <cstdint>
#include <limits>

namespace tactus::haptic {

/// How much a tick may still compute. It counts operations, never time, so that a run repeats bit
/// for bit on any machine. One unit is about 4 ns of a 2020s desktop processor
/// (bench_haptic_speed). Whoever finds it exhausted leaves its result unused: the search it was
/// part of is incomplete.
class WorkLimit {
public:
  static constexpr std::int64_t kUnlimited = std::numeric_limits<std::int64_t>::max();

  explicit constexpr WorkLimit(std::int64_t units = kUnlimited) noexcept : remaining_(units) {}
  /// False when the limit has been passed.
  bool spend(std::int64_t units) noexcept {
    remaining_ -= units;
    return remaining_ >= 0;
  }
  [[nodiscard]] bool exhausted() const noexcept { return remaining_ < 0; }
  [[nodiscard]] std::int64_t remaining() const noexcept { return remaining_; }

private:
  std::int64_t remaining_;
};

} // namespace tactus::haptic

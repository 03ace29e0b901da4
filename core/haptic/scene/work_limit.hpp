#pragma once

#include <cstdint>
#include <limits>

namespace tactus::haptic {

/// The work that a tick may still do. It is counted in operations instead of time, so that a run
/// repeats bit for bit on any machine. One unit takes about 6 ns on a desktop processor of the
/// 2020s (bench_haptic_speed). When it is exhausted a search is incomplete and its result must not
/// be used.
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

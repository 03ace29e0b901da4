#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::haptic {

/// Histogram of durations from 0.1 us to 10 s in bins of 5 %: a quantile is right to 2.5 %, a
/// value below the range falls into the first bin, one above into the last.
class DurationHistogram {
public:
  void add(double seconds) noexcept;
  void reset() noexcept { *this = {}; }
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] double mean_s() const noexcept;
  [[nodiscard]] double max_s() const noexcept { return max_s_; }
  /// Geometric middle of the bin that holds the share-th part of the values, never above the
  /// longest; 0 when empty.
  [[nodiscard]] double quantile_s(double probability) const noexcept;

private:
  static constexpr std::size_t kBins = 378; // ln(1e8) / ln(1.05)
  std::array<std::uint32_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  double sum_s_ = 0, max_s_ = 0;
};

} // namespace tactus::haptic

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::haptic {

/// Histogram of durations from 0.1 us to 10 s in bins of 5 %, so that a quantile is exact to 2.5 %.
/// A value below the range counts in the first bin, a value above it in the last bin.
class DurationHistogram {
public:
  void add(double seconds) noexcept;
  void reset() noexcept { *this = {}; }
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] double mean_s() const noexcept;
  [[nodiscard]] double max_s() const noexcept { return max_s_; }
  /// The quantile for a probability of 0..1: the geometric centre of its bin, never above max_s();
  /// 0 when empty.
  [[nodiscard]] double quantile_s(double probability) const noexcept;

private:
  static constexpr std::size_t kBins = 378; // ln(1e8) / ln(1.05)
  std::array<std::uint32_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  double sum_s_ = 0, max_s_ = 0;
};

} // namespace tactus::haptic

#include "core/haptic/servo/statistics.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::haptic {
namespace {
constexpr double kShortest_s = 1e-7;
constexpr double kLogRatio = 0.048790164169432003; // ln 1.05
} // namespace

void DurationHistogram::add(double seconds) noexcept {
  if (std::isnan(seconds))
    return;
  seconds = std::clamp(seconds, 0.0, 1e9);
  const double bin_position =
      seconds > kShortest_s ? math::log(seconds / kShortest_s) / kLogRatio : 0.0;
  const auto bin = std::min(static_cast<std::size_t>(bin_position), kBins - 1);
  ++bins_[bin];
  ++count_;
  sum_s_ += seconds;
  max_s_ = std::max(max_s_, seconds);
}

double DurationHistogram::mean_s() const noexcept {
  return count_ ? sum_s_ / static_cast<double>(count_) : 0.0;
}

double DurationHistogram::quantile_s(double probability) const noexcept {
  if (count_ == 0)
    return 0.0;
  const double target_rank = std::clamp(probability, 0.0, 1.0) * static_cast<double>(count_);
  double seen = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (bins_[bin] && seen >= target_rank)
      return std::min(max_s_,
                      kShortest_s * math::exp((static_cast<double>(bin) + 0.5) * kLogRatio));
  }
  return max_s_;
}

} // namespace tactus::haptic

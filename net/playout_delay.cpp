#include "net/playout_delay.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::net {
namespace {

constexpr double kLook_s = 0.02; ///< between two searches of the histogram

} // namespace

void PlayoutDelay::age(double now_s) noexcept {
  if (now_s - began_s_ < kGeneration_s)
    return;
  const bool both = now_s - began_s_ >= 2 * kGeneration_s;
  began_s_ = now_s;
  current_ = 1 - current_;
  counts_[current_] = {};
  totals_[current_] = 0;
  if (both) {
    counts_[1 - current_] = {};
    totals_[1 - current_] = 0;
  }
}

void PlayoutDelay::add(double delay_s, double now_s) noexcept {
  age(now_s);
  const auto bin = static_cast<std::size_t>(std::clamp(delay_s / kBin_s, 0.0, double{kBins}));
  ++counts_[current_][bin];
  ++totals_[current_];
  follow(now_s);
  value_s_ = std::min(kMax_s, std::max(value_s_, delay_s + kMargin_s));
}

double PlayoutDelay::quantile_s() const noexcept {
  const auto total = static_cast<double>(totals_[0] + totals_[1]);
  const double wanted = std::ceil(kShare * total);
  double count = 0;
  std::size_t bin = 0;
  for (; bin < kBins; ++bin) {
    count += counts_[0][bin] + counts_[1][bin];
    if (count >= wanted)
      break;
  }
  return kBin_s * static_cast<double>(bin + 1);
}

void PlayoutDelay::follow(double now_s) noexcept {
  if (now_s - looked_s_ >= kLook_s) {
    looked_s_ = now_s;
    // A line on which nothing comes keeps what was measured.
    if (totals_[0] + totals_[1] > 0)
      target_s_ = std::min(kMax_s, quantile_s() + kMargin_s);
  }
  const double passed_s = std::clamp(now_s - last_s_, 0.0, 1.0);
  last_s_ = std::max(last_s_, now_s);
  value_s_ = std::max(target_s_, value_s_ - kFall_rate * passed_s);
}

double PlayoutDelay::value(double now_s) noexcept {
  follow(now_s);
  return fixed_s_ ? std::clamp(*fixed_s_, 0.0, kMax_s) : value_s_;
}

} // namespace tactus::net

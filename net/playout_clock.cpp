#include "net/playout_clock.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::net {
namespace {

constexpr double kMicro = 1e-6;

/// Difference of two clock readings modulo 2^32 us, s.
double difference_s(std::uint32_t a, std::uint32_t b) noexcept {
  return kMicro * static_cast<std::int32_t>(a - b);
}

} // namespace

std::uint32_t stamp_of(double clock_s) noexcept {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(clock_s / kMicro + 0.5)));
}

void MinimumFilter::add(double sample, double now_s) noexcept {
  const auto second = std::max(newest_, static_cast<std::int64_t>(std::floor(now_s)));
  newest_ = second;
  Bin& bin = bins_[static_cast<std::size_t>(second) % bins_.size()];
  if (bin.second != second)
    bin = {second, sample};
  else
    bin.minimum = std::min(bin.minimum, sample);
}

std::optional<double> MinimumFilter::value(double now_s) const noexcept {
  if (newest_ < 0)
    return {};
  const auto oldest = static_cast<std::int64_t>(std::floor(now_s - kWindow_s));
  double minimum = bins_[static_cast<std::size_t>(newest_) % bins_.size()].minimum;
  for (const Bin& bin : bins_)
    if (bin.second >= std::max<std::int64_t>(oldest, 0))
      minimum = std::min(minimum, bin.minimum);
  return minimum;
}

void SlewedOffset::update(double target_s, double now_s) noexcept {
  if (!known_)
    first_s_ = now_s;
  const double passed_s = known_ ? std::max(0.0, now_s - last_s_) : 0;
  last_s_ = now_s;
  known_ = true;
  const double error_s = target_s - value_s_;
  const double rate = std::clamp(std::abs(error_s) / kTimeConstant_s, kMin_rate, kMax_rate);
  value_s_ = now_s - first_s_ <= warm_up_s_
                 ? target_s
                 : value_s_ + std::clamp(error_s, -rate * passed_s, rate * passed_s);
}

double PlayoutClock::sample_of(std::uint32_t stamp, double arrived_s) const noexcept {
  return difference_s(stamp_of(arrived_s) - stamp, *origin_);
}

void PlayoutClock::add(std::uint32_t stamp, double arrived_s) noexcept {
  if (!origin_)
    origin_ = stamp_of(arrived_s) - stamp;
  minimum_.add(sample_of(stamp, arrived_s), arrived_s);
}

void PlayoutClock::set_remote_minimum(std::uint32_t minimum_us, double now_s) noexcept {
  const auto minimum_s = minimum_.value(now_s);
  if (!minimum_s)
    return;
  // The sum of both minima is the shortest round trip. It is small, however far apart the clocks
  // are.
  const auto here_us = *origin_ + stamp_of(*minimum_s);
  round_trip_s_ = std::max(0.0, difference_s(here_us + minimum_us, 0));
  offset_.update(*minimum_s - round_trip_s_ / 2, now_s);
}

std::optional<std::uint32_t> PlayoutClock::minimum_us(double now_s) const noexcept {
  const auto minimum_s = minimum_.value(now_s);
  if (!minimum_s)
    return {};
  return *origin_ + stamp_of(*minimum_s);
}

double PlayoutClock::delay_s(std::uint32_t stamp, double arrived_s) const noexcept {
  if (!origin_)
    return 0;
  const double sample_s = sample_of(stamp, arrived_s);
  const double from_s = known() ? offset_.value() : *minimum_.value(arrived_s);
  return std::max(0.0, sample_s - from_s);
}

} // namespace tactus::net

#include "core/reed/player/tongue.hpp"

#include "core/dsp/elementary.hpp"

#include <numbers>

namespace tactus::reed {

bool Tongue::factors(const double* mouth_pressure, double* factor, int count) noexcept {
  int i = 0;
  if (state_ == State::kOpen && opening_ == 1 && burst_excess_ == 0 && share_ == 1 &&
      !articulation_due_)
    while (i < count && mouth_pressure[i] >= kMinPressure)
      ++i;
  if (i > 0)
    samples_in_state_ = 0;
  if (i == count)
    return false;
  std::fill_n(factor, i, 1.0);
  for (; i < count; ++i)
    factor[i] = next_factor(mouth_pressure[i]);
  return true;
}

/// Factor for the next sample of mouth pressure.
double Tongue::next_factor(double pressure) noexcept {
  switch (state_) {
  case State::kNoBreath:
    samples_in_state_ = pressure < kMinPressure
                            ? samples_in_state_ + (samples_in_state_ < samples(kRestTime) ? 1 : 0)
                            : -1;
    if (samples_in_state_ >= 0) {
      articulation_due_ = false; // there is nothing to stop
      min_stop_samples_ = 0;
      soft_samples_ = 0;
      return 1;
    }
    begin_hold();
    if (!(burst_ > 0) && !articulation_due_) { // a breath that continues is not stopped later
      state_ = State::kOpen;
      samples_in_state_ = 0;
      opening_ = 1;
      return 1;
    }
    [[fallthrough]];
  case State::kBlocked:
    return process_blocked(pressure);
  case State::kClosing:
    opening_ = std::max(0.0, opening_ - 1 / (kOpeningTime * sample_rate_));
    if (opening_ == 0)
      begin_hold();
    return opening_gain();
  default:
    return process_open(pressure);
  }
}

void Tongue::begin_hold() noexcept {
  state_ = State::kBlocked;
  samples_in_state_ = 0;
  previous_pressure_ = burst_excess_ = opening_ = 0;
}

double Tongue::process_blocked(double pressure) noexcept {
  ++samples_in_state_;
  if (samples_in_state_ % samples(kRiseWindow) != 0)
    return 0;
  const double rise = pressure - previous_pressure_;
  const bool slow = rise < kMaxSlowRise * kRiseWindow && pressure < 10 * kMaxSlowRise * kRiseWindow;
  previous_pressure_ = pressure;
  if (samples_in_state_ < min_stop_samples_)
    return 0;
  if (slow || rise < 0.05 * pressure || samples_in_state_ >= samples(kMaxHoldTime)) {
    state_ = State::kOpen;
    burst_excess_ = slow || soft_samples_ > 0 ? 0 : burst_;
    share_ = soft_samples_ > 0 ? kSoftShare : 1;
    samples_in_state_ = min_stop_samples_ = 0;
    articulation_due_ = false;
  }
  return 0;
}

double Tongue::process_open(double pressure) noexcept {
  opening_ = std::min(1.0, opening_ + 1 / (kOpeningTime * sample_rate_));
  if (soft_samples_ > 0)
    --soft_samples_;
  else
    share_ = std::min(1.0, share_ + (1 - kSoftShare) / (kSoftRise * sample_rate_));
  burst_excess_ = burst_excess_ > kNegligible ? burst_excess_ * decay_ : 0;
  samples_in_state_ = pressure < kMinPressure ? samples_in_state_ + 1 : 0;
  if (samples_in_state_ >= samples(kRestTime)) {
    state_ = State::kNoBreath;
  } else if (articulation_due_) {
    articulation_due_ = false;
    state_ = State::kClosing;
  }
  return share_ * opening_gain() * (1 + burst_excess_);
}

double Tongue::opening_gain() const noexcept {
  return opening_ < 1 ? 0.5 - 0.5 * math::cos(std::numbers::pi * opening_) : 1;
}

} // namespace tactus::reed

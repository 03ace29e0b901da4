#include "core/reed/player/tongue.hpp"

#include <numbers>

namespace tactus::reed {

bool Tongue::factors(const double* mouth_pressure, double* factor, int count) noexcept {
  int i = 0;
  if (state_ == State::kOpen && open_ == 1 && extra_ == 0 && !articulation_)
    while (i < count && mouth_pressure[i] >= kStill)
      ++i;
  if (i > 0)
    since_ = 0;
  if (i == count)
    return false;
  std::fill_n(factor, i, 1.0);
  for (; i < count; ++i)
    factor[i] = next(mouth_pressure[i]);
  return true;
}

/// What the next sample of this pressure is multiplied by.
double Tongue::next(double pressure) noexcept {
  switch (state_) {
  case State::kResting:
    since_ = pressure < kStill ? since_ + (since_ < samples(kRest) ? 1 : 0) : -1;
    if (since_ >= 0) {
      articulation_ = false; // there is nothing to stop
      stop_ = 0;
      return 1;
    }
    hold();
    if (!(burst_ > 0) && !articulation_) { // a breath that goes on is not stopped later
      state_ = State::kOpen;
      since_ = 0;
      open_ = 1;
      return 1;
    }
    [[fallthrough]];
  case State::kHolding:
    return holding(pressure);
  case State::kClosing:
    open_ = std::max(0.0, open_ - 1 / (kOpening * sample_rate_));
    if (open_ == 0)
      hold();
    return share();
  default:
    return speaking(pressure);
  }
}

void Tongue::hold() noexcept {
  state_ = State::kHolding;
  since_ = 0;
  before_ = extra_ = open_ = 0;
}

double Tongue::holding(double pressure) noexcept {
  ++since_;
  if (since_ % samples(kLook) != 0)
    return 0;
  const double rise = pressure - before_;
  const bool slow = rise < kSteepest * kLook && pressure < 10 * kSteepest * kLook;
  before_ = pressure;
  if (since_ < stop_)
    return 0;
  if (slow || rise < 0.05 * pressure || since_ >= samples(kHold)) {
    state_ = State::kOpen;
    extra_ = slow ? 0 : burst_;
    since_ = stop_ = 0;
    articulation_ = false;
  }
  return 0;
}

double Tongue::speaking(double pressure) noexcept {
  open_ = std::min(1.0, open_ + 1 / (kOpening * sample_rate_));
  extra_ = extra_ > kNothing ? extra_ * decay_ : 0;
  since_ = pressure < kStill ? since_ + 1 : 0;
  if (since_ >= samples(kRest)) {
    state_ = State::kResting;
  } else if (articulation_) {
    articulation_ = false;
    state_ = State::kClosing;
  }
  return share() * (1 + extra_);
}

double Tongue::share() const noexcept {
  return open_ < 1 ? 0.5 - 0.5 * std::cos(std::numbers::pi * open_) : 1;
}

} // namespace tactus::reed

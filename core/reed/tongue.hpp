#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {

/// A player's tongue: it holds the breath back while that rises and lets it go at once, with a
/// little more for a moment.
///
/// Behind the tongue the mouth is at its pressure p_m before the valve feels any of it. Let go
/// within 1.5 ms, it is a step for the valve, which swings about its new place with nearly the
/// amplitude of the note, where a breath that rises over 20 ms starts it a hundred times smaller;
/// the note then takes ln(final/initial)/growth rate. For some cycles the pressure is higher,
///   p = p_m (1 + burst exp(-t/25 ms)),
/// and the growth faster.
///
/// It acts by itself where a breath begins: after at least 5 ms without pressure, and if that
/// rises by more than 4 Pa/ms. It waits until the breath has risen (to where it grows by less than
/// a twentieth in 2 ms), at most 12 ms. articulate() asks for it within a breath.
class Tongue {
public:
  /// Another rate puts it at rest.
  void prepare(double sample_rate) noexcept {
    if (sample_rate == sample_rate_)
      return;
    sample_rate_ = sample_rate;
    decay_ = std::exp(-1 / (kBurstTime * sample_rate));
    reset();
  }
  /// 0: none; 1: doubles the pressure at first.
  void set_burst(double burst) noexcept { burst_ = burst; }
  void reset() noexcept {
    state_ = State::kResting;
    since_ = samples(kRest);
    before_ = extra_ = open_ = 0;
    articulation_ = false;
  }
  /// Stops the breath for some 5 ms (up to 14 while it rises) and lets it go.
  void articulate() noexcept { articulation_ = true; }

  /// The next samples of mouth pressure, Pa, become what the valve feels, at most `highest`.
  void shape(double* mouth_pressure, int count, double highest) noexcept {
    if (!(burst_ > 0)) {
      if (count > 0)
        stay_away(mouth_pressure[count - 1]);
      return;
    }
    for (int i = 0; i < count; ++i)
      mouth_pressure[i] = std::min(next(mouth_pressure[i]), highest);
  }

private:
  enum class State { kResting, kHolding, kClosing, kOpen };
  static constexpr double kBurstTime = 0.025, kOpening = 1.5e-3, kRest = 5e-3; // s
  static constexpr double kHold = 12e-3, kLook = 2e-3;                         // s
  static constexpr double kStill = 1;                                          // Pa: no breath
  static constexpr double kSteepest = 4e3; // Pa/s that need no tongue

  [[nodiscard]] int samples(double seconds) const noexcept {
    return static_cast<int>(seconds * sample_rate_);
  }

  /// Without a tongue: a breath that goes on is not stopped by one that comes later.
  void stay_away(double pressure) noexcept {
    reset();
    if (pressure < kStill)
      return;
    state_ = State::kOpen;
    since_ = 0;
    open_ = 1;
  }
  double next(double pressure) noexcept {
    switch (state_) {
    case State::kResting:
      since_ = pressure < kStill ? since_ + (since_ < samples(kRest) ? 1 : 0) : -1;
      if (since_ >= 0)
        return pressure;
      hold();
      [[fallthrough]];
    case State::kHolding:
      return holding(pressure);
    case State::kClosing:
      open_ = std::max(0.0, open_ - 1 / (kOpening * sample_rate_));
      if (open_ == 0)
        hold();
      return pressure * share();
    default:
      return speaking(pressure);
    }
  }
  void hold() noexcept {
    state_ = State::kHolding;
    since_ = 0;
    before_ = extra_ = open_ = 0;
  }
  double holding(double pressure) noexcept {
    ++since_;
    if (since_ % samples(kLook) != 0)
      return 0;
    const double rise = pressure - before_;
    const bool slow = rise < kSteepest * kLook && pressure < 10 * kSteepest * kLook;
    before_ = pressure;
    if (slow || rise < 0.05 * pressure || since_ >= samples(kHold)) {
      state_ = State::kOpen;
      extra_ = slow ? 0 : burst_;
      since_ = 0;
      articulation_ = false;
    }
    return 0;
  }
  double speaking(double pressure) noexcept {
    open_ = std::min(1.0, open_ + 1 / (kOpening * sample_rate_));
    extra_ *= decay_;
    since_ = pressure < kStill ? since_ + 1 : 0;
    if (since_ >= samples(kRest)) {
      state_ = State::kResting;
    } else if (articulation_) {
      articulation_ = false;
      state_ = State::kClosing;
    }
    return pressure * share() * (1 + extra_);
  }
  [[nodiscard]] double share() const noexcept {
    return open_ < 1 ? 0.5 - 0.5 * std::cos(std::numbers::pi * open_) : 1;
  }

  double sample_rate_ = 0, burst_ = 0, decay_ = 1;
  State state_ = State::kResting;
  int since_ = 0;
  double before_ = 0, extra_ = 0, open_ = 0;
  bool articulation_ = false;
};

} // namespace tactus::reed

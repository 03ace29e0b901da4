#pragma once

#include <algorithm>
#include <cmath>

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
/// With a burst it acts by itself where a breath begins: after at least 5 ms without pressure, and
/// if that rises by more than 4 Pa/ms. It waits until the breath has risen (to where it grows by
/// less than a twentieth in 2 ms), at most 12 ms. articulate() asks for it within a breath.
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
  /// 0: none, the tongue only stops the breath when asked to; 1: doubles the pressure at first.
  void set_burst(double burst) noexcept { burst_ = burst; }
  void reset() noexcept {
    state_ = State::kNoBreath;
    samples_in_state_ = samples(kRestTime);
    previous_pressure_ = burst_excess_ = opening_ = 0;
    articulation_due_ = false;
    min_stop_samples_ = 0;
  }
  /// Stops the breath for `seconds`, or some 5 ms (up to 14 while it rises), and lets it go.
  void articulate(double seconds = 0) noexcept {
    articulation_due_ = true;
    min_stop_samples_ = std::max(min_stop_samples_, samples(seconds));
  }

  /// For the next samples of mouth pressure, Pa, what it is to be multiplied by. Returns whether
  /// that is anything but 1.
  bool factors(const double* mouth_pressure, double* factor, int count) noexcept;

private:
  enum class State { kNoBreath, kBlocked, kClosing, kOpen };
  static constexpr double kBurstTime = 0.025, kOpeningTime = 1.5e-3, kRestTime = 5e-3; // s
  static constexpr double kMaxHoldTime = 12e-3, kRiseWindow = 2e-3;                    // s
  static constexpr double kMinPressure = 1;   // Pa: no breath
  static constexpr double kNegligible = 1e-6; // of p_m
  static constexpr double kMaxSlowRise = 4e3; // Pa/s that need no tongue

  [[nodiscard]] int samples(double seconds) const noexcept {
    return static_cast<int>(seconds * sample_rate_);
  }

  double next_factor(double pressure) noexcept;
  void begin_hold() noexcept;
  double process_blocked(double pressure) noexcept;
  double process_open(double pressure) noexcept;
  [[nodiscard]] double opening_gain() const noexcept;

  double sample_rate_ = 0, burst_ = 0, decay_ = 1;
  State state_ = State::kNoBreath;
  int samples_in_state_ = 0,
      min_stop_samples_ = 0; // samples: in this state; that the breath is stopped at least
  double previous_pressure_ = 0, burst_excess_ = 0, opening_ = 0;
  bool articulation_due_ = false;
};

} // namespace tactus::reed

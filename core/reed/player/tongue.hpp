#pragma once

#include "core/dsp/elementary.hpp"

#include <algorithm>

namespace tactus::reed {

/// Tonguing: blocks the mouth pressure while it rises, then releases it within 1.5 ms, with a
/// decaying burst on top.
///
/// If the pressure is released at once, it is a step. The valve then starts with nearly the
/// amplitude of the note. A pressure that rises over 20 ms starts the valve with a hundredth of
/// that amplitude. The rise of the note takes ln(final/initial)/growth rate. The burst speeds up
/// the growth,
///   p = p_m (1 + burst exp(-t/25 ms)),   t the time since the release.
///
/// With burst > 0 the tongue acts automatically when a breath begins: after at least 5 ms below 1
/// Pa, if the pressure rises by more than 4 Pa/ms. The tongue waits until the pressure grows by
/// less than a twentieth in 2 ms, at most 12 ms. articulate() requests tonguing within a breath. No
/// allocation.
class Tongue {
public:
  static constexpr double kSoftShare = 0.3, kSoftRise = 0.05; ///< s

  /// sample_rate in Hz; another rate resets the tongue.
  void prepare(double sample_rate) noexcept {
    if (sample_rate == sample_rate_)
      return;
    sample_rate_ = sample_rate;
    decay_ = math::exp(-1 / (kBurstTime * sample_rate));
    reset();
  }
  /// Relative excess at the release: 1 doubles the pressure; 0: acts on articulate() only.
  void set_burst(double burst) noexcept { burst_ = burst; }
  void reset() noexcept {
    state_ = State::kNoBreath;
    samples_in_state_ = samples(kRestTime);
    previous_pressure_ = burst_excess_ = opening_ = 0;
    articulation_due_ = false;
    min_stop_samples_ = 0;
    soft_samples_ = 0;
    share_ = 1;
  }
  /// Blocks the breath for at least `seconds` (some 5 ms, up to 14 while it rises), then releases
  /// it. soft: duration, s, of a soft beginning at kSoftShare of the pressure, without a burst,
  /// before the pressure rises within kSoftRise.
  void articulate(double seconds = 0, double soft = 0) noexcept {
    articulation_due_ = true;
    soft_samples_ = samples(soft);
    min_stop_samples_ = std::max(min_stop_samples_, samples(seconds));
  }

  /// Factors for the next count samples of mouth pressure, Pa. False when all are 1; factor is then
  /// not written.
  bool factors(const double* mouth_pressure, double* factor, int count) noexcept;

private:
  enum class State { kNoBreath, kBlocked, kClosing, kOpen };
  static constexpr double kBurstTime = 0.025, kOpeningTime = 1.5e-3, kRestTime = 5e-3; // s
  static constexpr double kMaxHoldTime = 12e-3, kRiseWindow = 2e-3;                    // s
  static constexpr double kMinPressure = 1;   // Pa; below it there is no breath
  static constexpr double kNegligible = 1e-6; // share of p_m
  static constexpr double kMaxSlowRise = 4e3; // Pa/s, up to which a breath is not tongued

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
  int samples_in_state_ = 0;
  int min_stop_samples_ = 0; // smallest number of samples for which the breath is blocked
  int soft_samples_ = 0;     // samples left of a soft beginning
  double previous_pressure_ = 0, burst_excess_ = 0, opening_ = 0;
  double share_ = 1; // share of the pressure, in a soft beginning
  bool articulation_due_ = false;
};

} // namespace tactus::reed

#pragma once

#include "core/dsp/complex.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <array>
#include <cstddef>

namespace tactus::reed {

/// Pitch tracker and tuning controller of the player: measures the deviation of the sounding pitch
/// from the target note and integrates it to a trim of the instrument.
///
/// The bore pressure is demodulated by exp(-i phi), d phi/dt = 2 pi f, f the target (phi is
/// continuous while f moves), and smoothed by two one-pole filters at f/8 (2 to 100 Hz). The angle
/// by which the result turns per measurement is the pitch error e (relative). The trim is
///   d trim/dt = -e/tau,   tau = 1.5 times the delay of the two poles, at least 12 ms,
/// slow enough not to overshoot. Changes of the trim that the filters have not shown yet are
/// predicted and added to e.
///
/// - While f moves the sound lags by about one period; the gain is reduced then.
/// - After a leap, where the error is largest, the gain is doubled for 0.15 s.
/// - Without enough pressure at the target pitch the trim is held.
/// - |trim| <= 0.25 in ln f, about four semitones.
///
/// Trims are stored per quarter tone and interpolated linearly between, so that glides and vibrato
/// cause no jump. A note that has not sounded yet starts with the trim of the previous note. No
/// allocation.
class TuningController {
public:
  static constexpr int kPeriod = kControlPeriod; // samples per measurement

  TuningController() noexcept { clear_corrections(); }
  void prepare(double sample_rate) noexcept;
  /// Clears target, measurements, trim and memory.
  void reset() noexcept;
  /// Clears the memory of notes: the instrument has changed. The trim stays.
  void clear_corrections() noexcept;
  /// Target pitch, Hz, above 0 and below half the sample rate. A change by more than kMinLeap is a
  /// new note and restarts the measurement.
  void set_target(double frequency_hz) noexcept;
  /// Takes the next samples of bore pressure, Pa; at most kPeriod between two calls of update().
  void track_pitch(const double* bore_pressure, int count) noexcept;
  /// Updates the trim; to be called after every kPeriod samples.
  void update() noexcept;
  /// ln of the factor by which the pitch is to change from that of linear theory (tuned()).
  [[nodiscard]] double trim() const noexcept { return trim_; }
  /// True if a register other than that of the target has sounded for kWrongRegisterTime; no trim
  /// reaches the target from there.
  [[nodiscard]] bool wrong_register() const noexcept {
    return off_target_count_ * kPeriod > 2 * kWrongRegisterTime * sample_rate_;
  }
  /// Resets the detection of wrong_register(), for instance because the breath has ended.
  void clear_off_target() noexcept { off_target_count_ = 0; }
  /// Starts the present note again with trim 0, after `silence` (s) during which nothing counts as
  /// another register.
  void restart_note(double silence) noexcept;

  static constexpr double kWrongRegisterTime = 0.3; // s
  static constexpr double kMinLeap = 0.03;          // half a semitone within kPeriod samples

private:
  struct Sums {
    double real = 0, imaginary = 0, power = 0;
  };
  struct Correction {
    double trim = 0;
    bool confirmed = false; // the note has sounded in tune
  };
  static constexpr double kLowest = 8; // Hz, of the first remembered note
  static constexpr double kSteps = 24; // steps per octave
  static constexpr std::size_t kCount = 240;

  void select_note(double frequency_hz, bool leap) noexcept;
  /// Demodulates and smooths the period's sums and clears them.
  void smooth_period() noexcept;
  void adjust_trim(double difference) noexcept;
  void restart_smoothing() noexcept;
  void count_off_target(bool off_target) noexcept;

  double sample_rate_ = 48000, frequency_ = 0;
  std::array<double, kPeriod> cosine_{}, sine_{};
  Sums even_, odd_;
  Complex phase_step_ = 1, phase_ = 1, smoothed_ = 0, twice_smoothed_ = 0;
  double pitch_rate_ = 0, smoothed_pitch_rate_ = 0,
         twice_smoothed_pitch_rate_ = 0; // rates of ln f, per measurement
  // Sum of all changes of the trim: as requested, as the sound follows, as the filters show it.
  double correction_ = 0, sounded_correction_ = 0, smoothed_correction_ = 0,
         twice_smoothed_correction_ = 0, response_pole_ = 0;
  int settling_count_ = 0;   // measurements until the filters have settled
  int fast_count_ = 0;       // measurements left of the faster correction after a leap
  int silence_count_ = 0;    // measurements until another register counts
  int off_target_count_ = 0; // +2 per measurement off target, -1 per other
  std::array<Correction, kCount> corrections_{};
  std::size_t note_ = 0; // index of the remembered note below the target
  double fraction_ = 0;  // position of the target between that note and the next
  double pole_ = 0, smoothing_delay_ = 0, time_constant_ = 0.1, mean_power_ = 0, power_pole_ = 0,
         trim_ = 0;
  int sample_count_ = 0;
};

} // namespace tactus::reed

#pragma once

#include "core/reed/instrument/control_period.hpp"

#include <array>
#include <complex>
#include <cstddef>

namespace tactus::reed {

/// A player's ear: compares the pitch that sounds with the pitch meant, and says by how much the
/// instrument is to be played sharper or flatter.
///
/// The bore pressure is multiplied by exp(-i phi), d phi/dt = 2 pi f with f the pitch meant now
/// (the phase runs on while f moves), and smoothed by two one-pole filters; the angle that the
/// result turns by is the phase run ahead, and the trim follows with its negative, an integral
/// controller. It is as fast as the smoothing allows: the delay of the loop is that of the two
/// poles, and a third of its inverse keeps it from overshooting. While f moves the sound lags
/// behind by about one period, which is no fault of the tuning; the ear trusts less what it hears
/// then. After a leap, whose error is the largest, it is twice as fast for 0.15 s. It keeps still
/// where there is nothing to hear, no pressure at that pitch, and never goes farther than two
/// semitones.
///
/// What notes needed is remembered in steps of a quarter tone, between which the trim runs
/// straight, so that glides and vibrato pass through it without a jump. A note that is new starts
/// as the one before ended.
class TuningController {
public:
  static constexpr int kPeriod = kControlPeriod; // samples per measurement

  TuningController() noexcept { clear_corrections(); }
  void prepare(double sample_rate) noexcept;
  /// Forgets what it heard and its trim.
  void reset() noexcept;
  /// Forgets what the notes needed: the instrument is another one.
  void clear_corrections() noexcept;
  /// Pitch meant, Hz, > 0 and below half the sample rate. A pitch that leaps (by more than kLeap)
  /// is another note, which is listened to from its beginning.
  void set_target(double frequency_hz) noexcept;
  /// The next samples of bore pressure, Pa; at most kPeriod between two calls of hear().
  void track_pitch(const double* bore_pressure, int count) noexcept;
  /// Due after each kPeriod samples.
  void update() noexcept;
  /// Natural logarithm of the factor by which the pitch is to be changed from what linear theory
  /// chose.
  [[nodiscard]] double trim() const noexcept { return trim_; }
  /// Whether something else than the pitch meant, or one within reach, has sounded for
  /// kWrongRegisterTime: another register, which no trim brings back.
  [[nodiscard]] bool wrong_register() const noexcept {
    return off_target_count_ * kPeriod > 2 * kWrongRegisterTime * sample_rate_;
  }
  /// What sounds is only dying away: that it is another register counts for nothing.
  void clear_off_target() noexcept { off_target_count_ = 0; }
  /// The pitch meant is to be found again from where linear theory has it.
  void restart_note() noexcept;
  /// Time constant of the integral controller at the pitch meant, s.
  [[nodiscard]] double time_constant() const noexcept { return time_constant_; }

  static constexpr double kWrongRegisterTime = 0.3; // s
  static constexpr double kLeap = 0.03;             // half a semitone within kPeriod samples

private:
  struct Sums {
    double real = 0, imaginary = 0, power = 0;
  };
  struct Correction {
    double trim = 0;
    bool confirmed = false; // it has sounded in tune
  };
  static constexpr double kLowest = 8; // Hz, of the first known pitch
  static constexpr double kSteps = 24; // in an octave
  static constexpr std::size_t kCount = 240;

  void select_note(double frequency_hz, bool leap) noexcept;
  void adjust_trim(double difference) noexcept;
  void restart_smoothing() noexcept;
  void count_off_target(bool off_target) noexcept;

  double sample_rate_ = 48000, frequency_ = 0;
  std::array<double, kPeriod> cosine_{}, sine_{};
  Sums even_, odd_;
  std::complex<double> phase_step_ = 1, phase_ = 1, smoothed_ = 0, twice_smoothed_ = 0;
  double pitch_rate_ = 0, smoothed_pitch_rate_ = 0,
         twice_smoothed_pitch_rate_ = 0; // of ln f, per hearing
  // The changes asked for, as the sound shows them, and as the smoothing does.
  double correction_ = 0, sounded_correction_ = 0, smoothed_correction_ = 0,
         twice_smoothed_correction_ = 0, response_pole_ = 0;
  int settling_count_ = 0;   // hearings until the filters have settled
  int fast_count_ = 0;       // hearings since a leap, in which it corrects faster
  int off_target_count_ = 0; // hearings of something else, twice
  std::array<Correction, kCount> corrections_{};
  std::size_t note_ = 0; // the known pitch below the one meant,
  double fraction_ = 0;  // and the share of the one above
  double pole_ = 0, smoothing_delay_ = 0, time_constant_ = 0.1, mean_power_ = 0, power_pole_ = 0,
         trim_ = 0;
  int sample_count_ = 0;
};

} // namespace tactus::reed

#include "core/reed/player/tuning_controller.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

using std::numbers::pi;
constexpr double kMaxError = 0.28; // four semitones, as relative frequency
constexpr double kLimit = 0.25;
constexpr double kInTune = 0.006;    // ten cents, within which a correction is confirmed
constexpr double kMinAmplitude = 10; // Pa
// Amplitude at the target relative to the rms of the whole pressure: below the first there is no
// measurement, below the second another register may sound.
constexpr double kMinShare = 0.1, kMainRegisterShare = 0.35;
constexpr double kSoundingPressure = 100;           // Pa rms, above which a wrong register counts
constexpr double kFastFactor = 2, kFastTime = 0.15; // gain and duration (s) after a leap
constexpr double kMaxPitchRate = 2;                 // 1/s, of ln f; faster targets reduce the gain

} // namespace

void TuningController::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  power_pole_ = math::exp(-kPeriod / (0.02 * sample_rate));
  const double frequency = frequency_;
  reset();
  if (frequency > 0)
    set_target(frequency);
}

void TuningController::reset() noexcept {
  frequency_ = 0;
  fast_count_ = 0;
  phase_ = 1;
  smoothed_ = twice_smoothed_ = 0;
  pitch_rate_ = smoothed_pitch_rate_ = twice_smoothed_pitch_rate_ = 0;
  correction_ = smoothed_correction_ = twice_smoothed_correction_ = sounded_correction_ = 0;
  settling_count_ = off_target_count_ = silence_count_ = 0;
  even_ = odd_ = {};
  mean_power_ = trim_ = 0;
  sample_count_ = 0;
  clear_corrections();
}

void TuningController::clear_corrections() noexcept {
  for (Correction& entry : corrections_)
    entry = {trim_, false};
}

/// Finds the target among the remembered notes. Notes without a confirmed correction start with the
/// present trim, reduced with the distance of a leap.
void TuningController::select_note(double frequency_hz, bool leap) noexcept {
  const double at = std::clamp(kSteps * math::log2(frequency_hz / kLowest), 0.0, kCount - 1.5);
  const auto note = static_cast<std::size_t>(at);
  const double start = leap && frequency_ > 0
                           ? trim_ / (1 + std::abs(math::log2(frequency_hz / frequency_)) * 3)
                           : trim_;
  for (std::size_t i = note; i <= note + 1; ++i)
    if (!corrections_[i].confirmed && (leap || (i != note_ && i != note_ + 1)))
      corrections_[i].trim = start;
  note_ = note;
  fraction_ = at - static_cast<double>(note);
  trim_ =
      corrections_[note].trim + fraction_ * (corrections_[note + 1].trim - corrections_[note].trim);
}

void TuningController::restart_note(double silence) noexcept {
  for (std::size_t i = note_; i <= note_ + 1; ++i)
    corrections_[i] = {};
  trim_ = 0;
  restart_smoothing();
  silence_count_ = static_cast<int>(silence * sample_rate_ / kPeriod);
}

/// Counts measurements off target; two on target outweigh one off target.
void TuningController::count_off_target(bool off_target) noexcept {
  if (silence_count_ == 0)
    off_target_count_ = std::max(0, off_target_count_ + (off_target ? 2 : -1));
}

/// Discards the measurement so far, after a leap.
void TuningController::restart_smoothing() noexcept {
  smoothed_ = twice_smoothed_ = smoothed_pitch_rate_ = twice_smoothed_pitch_rate_ = 0;
  settling_count_ = static_cast<int>(smoothing_delay_ * sample_rate_ / kPeriod);
  off_target_count_ = 0;
}

/// Changes the trim at the target by `difference`: the trims of both neighbouring notes by their
/// weights, or in full if they are unconfirmed.
void TuningController::adjust_trim(double difference) noexcept {
  Correction& below = corrections_[note_];
  Correction& above = corrections_[note_ + 1];
  const double below_weight = below.confirmed ? 1 - fraction_ : 1,
               above_weight = above.confirmed ? fraction_ : 1;
  const double unit = difference / ((1 - fraction_) * below_weight + fraction_ * above_weight);
  below.trim = std::clamp(below.trim + unit * below_weight, -kLimit, kLimit);
  above.trim = std::clamp(above.trim + unit * above_weight, -kLimit, kLimit);
  trim_ = below.trim + fraction_ * (above.trim - below.trim);
}

void TuningController::set_target(double frequency_hz) noexcept {
  if (frequency_hz == frequency_) {
    pitch_rate_ = 0;
    return;
  }
  const bool leap = !(std::abs(frequency_hz - frequency_) < kMinLeap * frequency_);
  pitch_rate_ = leap ? 0 : frequency_hz / frequency_ - 1;
  select_note(frequency_hz, leap);
  frequency_ = frequency_hz;
  // exp(-i omega k) for one measurement, by doubling.
  const double omega = 2 * pi * frequency_hz / sample_rate_;
  cosine_[0] = 1;
  sine_[0] = 0;
  double c = math::cos(omega), s = math::sin(omega);
  for (std::size_t size = 1; size < cosine_.size(); size *= 2) {
    for (std::size_t i = 0; i < size; ++i) {
      cosine_[size + i] = cosine_[i] * c - sine_[i] * s;
      sine_[size + i] = cosine_[i] * s + sine_[i] * c;
    }
    const double twice = 2 * c * s;
    c = c * c - s * s;
    s = twice;
  }
  phase_step_ = {c, -s};
  // Two poles at an eighth of the pitch attenuate components one pitch away to 1/64.
  const double corner = std::clamp(frequency_hz / 8, 2.0, 100.0);
  pole_ = 1 / (1 + 2 * pi * corner * kPeriod / sample_rate_);
  smoothing_delay_ = 2 / (2 * pi * corner);
  time_constant_ = std::max(1.5 * smoothing_delay_, 0.012);
  response_pole_ = 1 / (1 + frequency_hz * kPeriod / (2 * sample_rate_));
  if (leap) {
    restart_smoothing();
    fast_count_ = static_cast<int>(kFastTime * sample_rate_ / kPeriod);
  }
}

void TuningController::track_pitch(const double* bore_pressure, int count) noexcept {
  count = std::min(count, kPeriod - sample_count_);
  const auto add = [&](int i, Sums& sums) {
    const double pressure = bore_pressure[i];
    const auto at = static_cast<std::size_t>(sample_count_ + i);
    sums.real += pressure * cosine_[at];
    sums.imaginary -= pressure * sine_[at];
    sums.power += pressure * pressure;
  };
  // Even and odd samples have sums of their own, which makes two shorter dependency chains. Which
  // sum takes a sample does not depend on how the stream is cut into blocks.
  Sums even = even_, odd = odd_;
  int i = 0;
  if (sample_count_ % 2 == 1 && count > 0)
    add(i++, odd);
  for (; i + 1 < count; i += 2) {
    add(i, even);
    add(i + 1, odd);
  }
  if (i < count)
    add(i, even);
  even_ = even;
  odd_ = odd;
  sample_count_ += count;
}

void TuningController::smooth_period() noexcept {
  const Complex sum(even_.real + odd_.real, even_.imaginary + odd_.imaginary);
  const Complex demodulated = phase_ * sum / static_cast<double>(kPeriod);
  phase_ *= phase_step_;
  phase_ /= std::sqrt(math::norm(phase_));
  smoothed_ = demodulated + pole_ * (smoothed_ - demodulated);
  twice_smoothed_ = smoothed_ + pole_ * (twice_smoothed_ - smoothed_);
  smoothed_pitch_rate_ = pitch_rate_ + pole_ * (smoothed_pitch_rate_ - pitch_rate_);
  twice_smoothed_pitch_rate_ =
      smoothed_pitch_rate_ + pole_ * (twice_smoothed_pitch_rate_ - smoothed_pitch_rate_);
  sounded_correction_ = correction_ + response_pole_ * (sounded_correction_ - correction_);
  smoothed_correction_ = sounded_correction_ + pole_ * (smoothed_correction_ - sounded_correction_);
  twice_smoothed_correction_ =
      smoothed_correction_ + pole_ * (twice_smoothed_correction_ - smoothed_correction_);
  const double power = (even_.power + odd_.power) / kPeriod;
  mean_power_ = power + power_pole_ * (mean_power_ - power);
  even_ = odd_ = {};
  sample_count_ = 0;
}

void TuningController::update() noexcept {
  if (sample_count_ == 0)
    return;
  silence_count_ = std::max(0, silence_count_ - 1);
  const Complex before = twice_smoothed_;
  smooth_period();
  const double amplitude = 2 * std::sqrt(math::norm(twice_smoothed_));
  if (!(amplitude < 1e9)) {
    const double saved_trim = trim_;
    reset();
    trim_ = saved_trim;
    clear_corrections();
    return;
  }
  if (amplitude < kMinAmplitude || amplitude * amplitude < kMinShare * kMinShare * mean_power_) {
    settling_count_ =
        std::max(settling_count_, static_cast<int>(time_constant_ * sample_rate_ / kPeriod));
    count_off_target(mean_power_ > kSoundingPressure * kSoundingPressure);
    return;
  }
  if (settling_count_ > 0) {
    --settling_count_;
    return;
  }
  const double period = kPeriod / sample_rate_;
  const double measured_error =
      math::arg(twice_smoothed_ * math::conj(before)) / (2 * pi * frequency_ * period);
  if (!(std::abs(measured_error) < kMaxError)) {
    count_off_target(true);
    return;
  }
  const double error = measured_error + correction_ - twice_smoothed_correction_;
  const double relative_pitch_rate = twice_smoothed_pitch_rate_ / (period * kMaxPitchRate);
  const double speed_up = fast_count_ > 0 ? kFastFactor : 1;
  fast_count_ = std::max(0, fast_count_ - 1);
  const double step = -error * speed_up * period /
                      (time_constant_ * (1 + relative_pitch_rate * relative_pitch_rate));
  correction_ += step;
  adjust_trim(step);
  const bool other = mean_power_ > kSoundingPressure * kSoundingPressure &&
                     amplitude * amplitude < kMainRegisterShare * kMainRegisterShare * mean_power_;
  count_off_target(other || (std::abs(trim_) > 0.98 * kLimit && trim_ * step > 0));
  if (std::abs(error) < kInTune) {
    corrections_[note_].confirmed |= fraction_ < 0.7;
    corrections_[note_ + 1].confirmed |= fraction_ > 0.3;
  }
}

} // namespace tactus::reed

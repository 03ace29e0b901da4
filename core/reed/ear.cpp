#include "core/reed/ear.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

constexpr double kTime = 0.1;      // s, of the integral controller
constexpr double kFarthest = 0.12; // two semitones, as relative frequency
constexpr double kLimit = kFarthest;
constexpr double kInTune = 0.006;  // ten cents: what is remembered as right
constexpr double kQuiet = 10;      // Pa
constexpr double kShare = 0.1;     // of the whole pressure's rms

} // namespace

void Ear::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  power_pole_ = std::exp(-kPeriod / (0.02 * sample_rate));
  const double frequency = frequency_;
  frequency_ = 0;
  if (frequency > 0)
    mean(frequency);
  reset();
}

void Ear::reset() noexcept {
  phase_ = 1;
  smooth_ = smoother_ = 0;
  even_ = odd_ = {};
  loudness_ = trim_ = 0;
  place_ = 0;
  forget();
}

void Ear::mean(double frequency_hz) noexcept {
  if (frequency_hz == frequency_)
    return;
  frequency_ = frequency_hz;
  const double note = std::clamp(69.5 + 12 * std::log2(frequency_hz / 440), 0.0, 127.0);
  if (static_cast<std::size_t>(note) != note_) {
    note_ = static_cast<std::size_t>(note);
    if (known_[note_] != kUnknown)
      trim_ = known_[note_];
  }
  const double omega = 2 * std::numbers::pi * frequency_hz / sample_rate_;
  for (std::size_t i = 0; i < cosine_.size(); ++i) {
    cosine_[i] = std::cos(omega * static_cast<double>(i));
    sine_[i] = std::sin(omega * static_cast<double>(i));
  }
  turn_ = std::polar(1.0, -omega * kPeriod);
  // Two poles at an eighth of the pitch leave 1/64 of what lies a pitch away.
  const double corner = std::clamp(frequency_hz / 8, 2.0, 100.0);
  pole_ = std::exp(-2 * std::numbers::pi * corner * kPeriod / sample_rate_);
  smooth_ = smoother_ = 0;
}

void Ear::listen(const double* bore_pressure, int count) noexcept {
  count = std::min(count, kPeriod - place_);
  const auto add = [&](int i, Sums& sums) {
    const double pressure = bore_pressure[i];
    const auto at = static_cast<std::size_t>(place_ + i);
    sums.real += pressure * cosine_[at];
    sums.imaginary -= pressure * sine_[at];
    sums.power += pressure * pressure;
  };
  // Samples of even and of odd place side by side, for each sum has to wait for itself; which sum
  // takes a sample does not depend on how the stream is cut.
  Sums even = even_, odd = odd_;
  int i = 0;
  if (place_ % 2 == 1 && count > 0)
    add(i++, odd);
  for (; i + 1 < count; i += 2) {
    add(i, even);
    add(i + 1, odd);
  }
  if (i < count)
    add(i, even);
  even_ = even;
  odd_ = odd;
  place_ += count;
}

double Ear::trim() noexcept {
  if (place_ == 0)
    return trim_;
  const std::complex<double> sum(even_.real + odd_.real, even_.imaginary + odd_.imaginary);
  const std::complex<double> heard = phase_ * sum / static_cast<double>(kPeriod);
  phase_ *= turn_;
  phase_ /= std::abs(phase_);
  const std::complex<double> before = smoother_;
  smooth_ = heard + pole_ * (smooth_ - heard);
  smoother_ = smooth_ + pole_ * (smoother_ - smooth_);
  const double power = (even_.power + odd_.power) / kPeriod;
  loudness_ = power + power_pole_ * (loudness_ - power);
  even_ = odd_ = {};
  place_ = 0;
  const double amplitude = 2 * std::abs(smoother_);
  if (!(amplitude < 1e9)) {
    const double kept = trim_;
    reset();
    return trim_ = kept;
  }
  if (amplitude < kQuiet || amplitude * amplitude < kShare * kShare * loudness_ ||
      std::abs(before) < 0.5 * std::abs(smoother_))
    return trim_;
  const double period = kPeriod / sample_rate_;
  const double error =
      std::arg(smoother_ * std::conj(before)) / (2 * std::numbers::pi * frequency_ * period);
  if (std::abs(error) < kFarthest)
    trim_ = std::clamp(trim_ - error * period / kTime, -kLimit, kLimit);
  if (std::abs(error) < kInTune)
    known_[note_] = trim_;
  return trim_;
}

} // namespace tactus::reed

#include "core/reed/ear.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

constexpr double kTime = 0.12;     // s, of the integral controller
constexpr double kFarthest = 0.15; // two and a half semitones, as relative frequency
constexpr double kLimit = 0.25;    // a little over four semitones
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
  sum_ = smooth_ = smoother_ = 0;
  power_ = loudness_ = trim_ = 0;
  place_ = 0;
}

void Ear::mean(double frequency_hz) noexcept {
  if (frequency_hz == frequency_)
    return;
  frequency_ = frequency_hz;
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
  double real = 0, imaginary = 0, power = 0;
  for (int i = 0; i < count; ++i) {
    const std::size_t at = static_cast<std::size_t>(place_ + i) % kPeriod;
    real += bore_pressure[i] * cosine_[at];
    imaginary -= bore_pressure[i] * sine_[at];
    power += bore_pressure[i] * bore_pressure[i];
  }
  sum_ += std::complex<double>(real, imaginary);
  power_ += power;
  place_ += count;
}

double Ear::trim() noexcept {
  if (place_ == 0)
    return trim_;
  const std::complex<double> heard = phase_ * sum_ / static_cast<double>(kPeriod);
  phase_ *= turn_;
  phase_ /= std::abs(phase_);
  const std::complex<double> before = smoother_;
  smooth_ = heard + pole_ * (smooth_ - heard);
  smoother_ = smooth_ + pole_ * (smoother_ - smooth_);
  const double power = power_ / kPeriod;
  loudness_ = power + power_pole_ * (loudness_ - power);
  sum_ = power_ = 0;
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
  return trim_;
}

} // namespace tactus::reed

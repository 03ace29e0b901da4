#include "core/footstep/room.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::footstep {
namespace {

/// Delays without common divisors at common sample rates, so that echoes rarely coincide.
constexpr double kDelays[] = {0.00711, 0.00967, 0.01229, 0.01493,
                              0.01787, 0.02111, 0.02473, 0.02887};
constexpr double kSilentPressure = 1e-12, kMaxPressure = 1e9;
constexpr double kRingOutFactor = 1.5; // time in which a sound decays by 90 dB, relative to t60

double clamped(double value, double lowest, double highest) noexcept {
  return value > lowest ? std::min(value, highest) : lowest;
}

/// Pole of the one-pole low-pass that has gain 1 at 0 Hz and the given gain at w rad per sample.
double pole_for(double gain, double w) noexcept {
  const double square = gain * gain;
  const double b = (1 - square * math::cos(w)) / (1 - square);
  return b - std::sqrt(b * b - 1);
}

} // namespace

void Room::prepare(double sample_rate) {
  sample_rate_ = sample_rate;
  for (std::size_t i = 0; i < kLines; ++i) {
    const auto length = static_cast<std::size_t>(kDelays[i] * sample_rate) | 1U;
    if (lines_[i].samples.size() != length) {
      lines_[i].samples.assign(length, 0.0);
      lines_[i].at = 0;
      filter_state_[i] = 0;
      ring_out_left_ = 0;
    }
  }
  set(settings_);
}

void Room::set(const Settings& settings) noexcept {
  settings_ = settings;
  const double t60 = clamped(settings.t60_s, 0.02, 10);
  const double w =
      2 * std::numbers::pi * clamped(settings.bright_hz, 100, 0.45 * sample_rate_) / sample_rate_;
  double mean = 0; // mean of the gains' squares
  for (std::size_t i = 0; i < kLines; ++i) {
    gain_[i] = math::exp10(-3 * kDelays[i] / t60);
    pole_[i] = pole_for(gain_[i], w);
    mean += gain_[i] * gain_[i] / kLines;
  }
  // Each pass of an impulse through the delays leaves the share `mean` of its energy, so the output
  // energy is mean + mean^2 + ...
  const double level_db = clamped(settings.level_db, kMinLevel, 40);
  level_ = level_db > kMinLevel ? std::sqrt(math::exp10(level_db / 10) * (1 - mean) / mean) : 0;
  ring_out_samples_ = static_cast<long>(kRingOutFactor * t60 * sample_rate_);
}

void Room::reset() noexcept {
  for (Line& line : lines_)
    std::fill(line.samples.begin(), line.samples.end(), 0.0);
  filter_state_ = {};
  ring_out_left_ = 0;
}

double Room::next(double direct) noexcept {
  if (!(std::abs(direct) < kMaxPressure))
    direct = 0;
  if (level_ > 0 && std::abs(direct) > kSilentPressure)
    ring_out_left_ = ring_out_samples_;
  else if (ring_out_left_ == 0)
    return 0;
  else
    --ring_out_left_;
  std::array<double, kLines> v;
  for (std::size_t i = 0; i < kLines; ++i)
    v[i] = lines_[i].samples[lines_[i].at];
  for (std::size_t i = 0; i < kLines; ++i) {
    const double decayed = gain_[i] * v[i];
    v[i] = filter_state_[i] = decayed + pole_[i] * (filter_state_[i] - decayed);
  }
  double out = 0;
  for (std::size_t i = 0; i < kLines; ++i)
    out += i % 3 == 1 ? -v[i] : v[i];
  // Hadamard's matrix of order 8, orthogonal once divided by the square root of 8.
  for (std::size_t half = 1; half < kLines; half *= 2)
    for (std::size_t i = 0; i < kLines; ++i)
      if ((i & half) == 0) {
        const double a = v[i], b = v[i + half];
        v[i] = a + b;
        v[i + half] = a - b;
      }
  constexpr double kShare = 0.35355339059327379; // 1 / sqrt(8)
  for (std::size_t i = 0; i < kLines; ++i) {
    Line& line = lines_[i];
    const double in = kShare * (v[i] + (i % 2 ? -direct : direct));
    line.samples[line.at] = std::abs(in) > kSilentPressure * kSilentPressure ? in : 0;
    if (++line.at == line.samples.size())
      line.at = 0;
  }
  return level_ * out;
}

} // namespace tactus::footstep

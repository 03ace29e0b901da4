#include "core/particle/grain_bank.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::particle {

void GrainBank::prepare(double sample_rate) noexcept {
  if (sample_rate == sample_rate_)
    return;
  sample_rate_ = sample_rate;
  reset();
}

void GrainBank::reset() noexcept {
  count_ = 0;
  until_check_ = kCheckInterval;
}

void GrainBank::start(const Grain& grain, Random& random) noexcept {
  if (count_ == kMaxGrains || !(grain.strength > 0))
    return;
  const double frequency = std::clamp(grain.frequency_hz, 10.0, 0.45 * sample_rate_);
  const double quality = std::clamp(grain.quality, 0.1, 200.0);
  const double length = std::clamp(grain.length_s, 1e-5, 2.0);
  const double w = 2 * std::numbers::pi * frequency / sample_rate_;
  const double a = math::sin(w) / (2 * quality);
  const double decay_factor = math::exp(-1 / (length * sample_rate_));
  const double noise_deviation =
      grain.strength * std::sqrt(sample_rate_ * (1 - decay_factor * decay_factor) * (1 + a) / a);
  // Standard deviation of a uniform 32-bit integer.
  constexpr double kIntegerDeviation = 4294967296.0 / 3.4641016151377546;
  const std::size_t i = count_++;
  envelope_[i] = noise_deviation / kIntegerDeviation;
  decay_factor_[i] = decay_factor;
  gain_[i] = a / (1 + a);
  a1_[i] = -2 * math::cos(w) / (1 + a);
  a2_[i] = (1 - a) / (1 + a);
  x1_[i] = x2_[i] = y1_[i] = y2_[i] = 0;
  noise_[i] = static_cast<std::uint32_t>(random.next() >> 32) | 1U;
  // Envelope and filter have both decayed by 60 dB.
  const double life_s = 6.9 * (length + quality / (std::numbers::pi * frequency));
  samples_left_[i] = static_cast<std::int32_t>(std::min(life_s, 4.0) * sample_rate_) + 1;
}

double GrainBank::next() noexcept {
  if (count_ == 0)
    return 0;
  const std::size_t count = count_;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t n = noise_[i]; // xorshift32, Marsaglia 2003
    n ^= n << 13;
    n ^= n >> 17;
    n ^= n << 5;
    noise_[i] = n;
    const double x = envelope_[i] * static_cast<double>(static_cast<std::int32_t>(n));
    envelope_[i] *= decay_factor_[i];
    const double y = gain_[i] * (x - x2_[i]) - a1_[i] * y1_[i] - a2_[i] * y2_[i];
    x2_[i] = x1_[i];
    x1_[i] = x;
    y2_[i] = y1_[i];
    y1_[i] = y;
    sound_[i] = y;
    --samples_left_[i];
  }
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i)
    sum += sound_[i];
  if (--until_check_ == 0) {
    until_check_ = kCheckInterval;
    remove_ended();
  }
  return sum;
}

void GrainBank::remove_ended() noexcept {
  for (std::size_t i = 0; i < count_;) {
    if (samples_left_[i] > 0) {
      ++i;
      continue;
    }
    const std::size_t last = --count_;
    for (auto* values : {&envelope_, &decay_factor_, &gain_, &a1_, &a2_, &x1_, &x2_, &y1_, &y2_})
      (*values)[i] = (*values)[last];
    noise_[i] = noise_[last];
    samples_left_[i] = samples_left_[last];
  }
}

} // namespace tactus::particle

#include "core/particle/bubble_bank.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::particle {

double bubble_frequency_hz(double radius_m) noexcept { return 3 / radius_m; }

double bubble_decay_per_s(double radius_m) noexcept {
  return 0.13 / radius_m + 0.0072 / (radius_m * std::sqrt(radius_m));
}

void BubbleBank::prepare(double sample_rate) noexcept {
  if (sample_rate == sample_rate_)
    return;
  sample_rate_ = sample_rate;
  reset();
}

void BubbleBank::start(double radius_m, double amplitude, double rise) noexcept {
  if (count_ == kMaxBubbles || !(std::abs(amplitude) > 0))
    return;
  const double radius = std::clamp(radius_m, 0.15e-3, 0.15);
  const double decay = bubble_decay_per_s(radius);
  const double frequency = bubble_frequency_hz(radius);
  if (frequency > 0.45 * sample_rate_)
    return;
  const double chirp = std::clamp(rise, 0.0, 1.0) * decay; // relative, 1/s
  const double step_s = 1 / sample_rate_;
  const double chirp_angle = 2 * std::numbers::pi * frequency * chirp * step_s * step_s;
  // phase(n) = w n + chirp_angle n^2 / 2, so the first rotation is by w + chirp_angle / 2.
  const double first_angle = 2 * std::numbers::pi * frequency * step_s + 0.5 * chirp_angle;
  const double decay_factor = math::exp(-decay * step_s);
  double life_s = 6.9 / decay; // 60 dB
  if (chirp > 0)               // the bubble ends before its frequency reaches 0.48 of the sample
                               // rate
    life_s = std::min(life_s, (0.48 * sample_rate_ / frequency - 1) / chirp);
  const double angular = 2 * std::numbers::pi * frequency;
  bubbles_[count_++] = {amplitude,
                        0,
                        amplitude,
                        decay_factor,
                        1,
                        chirp * step_s,
                        decay / angular,
                        chirp / angular,
                        decay_factor * math::cos(first_angle),
                        decay_factor * math::sin(first_angle),
                        math::cos(chirp_angle),
                        math::sin(chirp_angle),
                        static_cast<long>(life_s * sample_rate_)};
}

double BubbleBank::next() noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < count_;) {
    Bubble& b = bubbles_[i];
    const double per_pitch = 1 / b.pitch;
    sum += b.imaginary - (b.flow + b.chirp_flow * per_pitch) * per_pitch * (b.envelope - b.real);
    b.envelope *= b.decay_factor;
    b.pitch += b.pitch_step;
    const double real = b.real * b.rotation_real - b.imaginary * b.rotation_imaginary;
    b.imaginary = b.real * b.rotation_imaginary + b.imaginary * b.rotation_real;
    b.real = real;
    const double new_rotation_real =
        b.rotation_real * b.chirp_real - b.rotation_imaginary * b.chirp_imaginary;
    b.rotation_imaginary =
        b.rotation_real * b.chirp_imaginary + b.rotation_imaginary * b.chirp_real;
    b.rotation_real = new_rotation_real;
    if (--b.samples_left <= 0)
      b = bubbles_[--count_];
    else
      ++i;
  }
  return sum;
}

} // namespace tactus::particle

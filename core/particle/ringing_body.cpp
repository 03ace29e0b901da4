#include "core/particle/ringing_body.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::particle {

void RingingBody::prepare(double sample_rate) noexcept {
  if (sample_rate == sample_rate_)
    return;
  sample_rate_ = sample_rate;
  reset();
  update();
}

void RingingBody::set(std::span<const RingingMode> modes) noexcept {
  count_ = std::min(modes.size(), kMaxModes);
  std::copy_n(modes.begin(), count_, modes_.begin());
  used_ = std::max(used_, count_);
  update();
}

void RingingBody::update() noexcept {
  onset_.fill(0);
  for (std::size_t i = 0; i < count_; ++i) {
    const RingingMode& mode = modes_[i];
    const double d = math::log(1000.0) / std::clamp(mode.t60_s, 1e-4, 1e3);
    const double w = 2 * std::numbers::pi * std::max(mode.frequency_hz, 1.0);
    const double decay_factor = math::exp(-d / sample_rate_);
    pole_real_[i] = decay_factor * math::cos(w / sample_rate_);
    pole_imaginary_[i] = decay_factor * math::sin(w / sample_rate_);
    if (mode.frequency_hz < 0.45 * sample_rate_)
      onset_[i] = mode.gain * std::sqrt(4 * d * (w * w + d * d)) / w;
  }
}

void RingingBody::reset() noexcept {
  real_.fill(0);
  imaginary_.fill(0);
  used_ = count_;
  until_check_ = kCheckInterval;
  at_rest_ = true;
}

double RingingBody::next(double strength) noexcept {
  if (strength != 0 && count_ > 0)
    at_rest_ = false;
  if (at_rest_)
    return 0;
  double sum = 0;
  for (std::size_t i = 0; i < used_; ++i) {
    const double real = real_[i] + onset_[i] * strength; // the sine begins at 0
    sum += imaginary_[i];
    const double imaginary = imaginary_[i];
    real_[i] = real * pole_real_[i] - imaginary * pole_imaginary_[i];
    imaginary_[i] = real * pole_imaginary_[i] + imaginary * pole_real_[i];
  }
  if (--until_check_ == 0) {
    until_check_ = kCheckInterval;
    double largest = 0;
    for (std::size_t i = 0; i < used_; ++i)
      largest = std::max({largest, std::abs(real_[i]), std::abs(imaginary_[i])});
    if (largest < kSilence)
      reset();
  }
  return sum;
}

} // namespace tactus::particle

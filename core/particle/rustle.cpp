#include "core/particle/rustle.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::particle {
namespace {

/// Quantiles 1/12, 3/12, ... 11/12 of the normal distribution.
constexpr double kQuantiles[] = {-1.38299, -0.67449, -0.21043, 0.21043, 0.67449, 1.38299};
/// Standard deviation of a uniform 32-bit integer.
constexpr double kIntegerDeviation = 4294967296.0 / 3.4641016151377546;

} // namespace

void Rustle::set(double frequency_hz, double spread, double quality) noexcept {
  for (std::size_t i = 0; i < kBands; ++i) {
    const double frequency =
        std::clamp(frequency_hz * math::exp(spread * kQuantiles[i]), 10.0, 0.45 * sample_rate_);
    const double w = 2 * std::numbers::pi * frequency / sample_rate_;
    const double a = math::sin(w) / (2 * quality);
    // The bilinear band-pass passes a / (1 + a) of the variance of white noise.
    gain_[i] = a / (1 + a) * std::sqrt((1 + a) / a / kBands) / kIntegerDeviation;
    a1_[i] = -2 * math::cos(w) / (1 + a);
    a2_[i] = (1 - a) / (1 + a);
  }
}

void Rustle::reset() noexcept {
  for (auto* values : {&x1_, &x2_, &y1_, &y2_})
    values->fill(0);
  redraw();
}

double Rustle::next(Random& random) noexcept {
  if (noise_[0] == 0)
    for (std::uint32_t& n : noise_)
      n = static_cast<std::uint32_t>(random.next() >> 32) | 1U;
  std::array<double, kBands> y;
  for (std::size_t i = 0; i < kBands; ++i) {
    std::uint32_t n = noise_[i]; // xorshift32, Marsaglia 2003; never becomes 0
    n ^= n << 13;
    n ^= n >> 17;
    n ^= n << 5;
    noise_[i] = n;
    const double x = static_cast<double>(static_cast<std::int32_t>(n));
    y[i] = gain_[i] * (x - x2_[i]) - a1_[i] * y1_[i] - a2_[i] * y2_[i];
    x2_[i] = x1_[i];
    x1_[i] = x;
    y2_[i] = y1_[i];
    y1_[i] = y[i];
  }
  double sum = 0;
  for (const double band : y)
    sum += band;
  return sum;
}

} // namespace tactus::particle

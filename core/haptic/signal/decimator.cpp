#include "core/haptic/signal/decimator.hpp"

#include "core/dsp/elementary.hpp"

#include <cmath>
#include <numbers>

namespace tactus::haptic {
namespace {
constexpr double kMaxInput_n = 1e9;
constexpr double kDenormalThreshold = 1e-200; // a decaying state is set to 0 below it
} // namespace

void Decimator::set(double sample_rate_hz, double servo_rate_hz) noexcept {
  const double cutoff = kCutoffRatio * servo_rate_hz;
  bypass_ = !(cutoff > 0.0) || !(cutoff < 0.45 * sample_rate_hz);
  if (bypass_)
    return;
  const double k = math::tan(std::numbers::pi * cutoff / sample_rate_hz);
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    // Poles of the analogue filter lie at equal angles on the left half of a circle.
    const double angle = std::numbers::pi * (2.0 * static_cast<double>(i) + 1.0) / 16.0;
    const double loss = 2.0 * math::sin(angle) * k, scale = 1.0 / (1.0 + loss + k * k);
    sections_[i].b = k * k * scale;
    sections_[i].a1 = 2.0 * (k * k - 1.0) * scale;
    sections_[i].a2 = (1.0 - loss + k * k) * scale;
  }
}

void Decimator::reset() noexcept {
  for (Section& section : sections_)
    section.s1 = section.s2 = 0;
}

double Decimator::process(double input) noexcept {
  double x = std::abs(input) < kMaxInput_n ? input : 0.0; // false for NaN
  if (bypass_)
    return x;
  for (Section& s : sections_) {
    const double y = s.b * x + s.s1;
    s.s1 = 2.0 * s.b * x - s.a1 * y + s.s2;
    s.s2 = s.b * x - s.a2 * y;
    if (std::abs(s.s1) + std::abs(s.s2) < kDenormalThreshold)
      s.s1 = s.s2 = 0;
    x = y;
  }
  return x;
}

} // namespace tactus::haptic

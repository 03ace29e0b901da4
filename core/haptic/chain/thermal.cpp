#include "core/haptic/chain/thermal.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::haptic {
namespace {
constexpr double kFallsFrom = 0.5; // multiple of continuous^2: h at which the limit begins to fall
constexpr double kFallsTo = 0.9;   // multiple of continuous: the limit at h = continuous^2
constexpr double kWarmRatio = 0.5;
constexpr double kDeratingThreshold = 0.95; // share of the peak
constexpr double kCool = 0.4;               // multiple of continuous^2

/// Whether the force can exceed the continuous rating.
bool limits(const ThermalSettings& settings) noexcept {
  return settings.continuous_n > 0.0 && settings.continuous_n < settings.peak_n;
}

double reported_ceiling_n(const ThermalSettings& settings) noexcept {
  const double rated = settings.continuous_n, peak = settings.peak_n;
  return kWarmRatio * (rated > 0.0 ? std::min(rated, peak) : peak);
}
} // namespace

void ThermalLimit::advance(const ThermalSettings& settings, double force_n,
                           bool reported_warm) noexcept {
  const double decay = math::exp(-settings.period_s / kTimeConstant_s);
  heat_n2_ = decay * heat_n2_ + (1.0 - decay) * force_n * force_n;
  const double step = settings.period_s / (reported_warm ? kWarmRamp_s : -kCoolRamp_s);
  warm_ = std::clamp(warm_ + step, 0.0, 1.0);
  reported_ = reported_warm;
  const double now_n = ceiling_n(settings), rated = settings.continuous_n;
  if (now_n < kDeratingThreshold * settings.peak_n)
    derating_ = true;
  else if (!(now_n < settings.peak_n) && (!limits(settings) || heat_n2_ < kCool * rated * rated))
    derating_ = false;
}

double ThermalLimit::steady_limit_n(const ThermalSettings& settings) const noexcept {
  const double peak = settings.peak_n, rated = settings.continuous_n;
  if (reported_)
    return reported_ceiling_n(settings);
  if (!limits(settings))
    return peak;
  const double begin = kFallsFrom * rated * rated, low = kFallsTo * rated;
  const double slope = (peak * peak - low * low) / (rated * rated - begin);
  return std::sqrt((peak * peak + slope * begin) / (1 + slope));
}

double ThermalLimit::ceiling_n(const ThermalSettings& settings) const noexcept {
  const double peak = settings.peak_n;
  const double rated = settings.continuous_n;
  double ceiling = peak;
  if (limits(settings)) {
    const double share =
        std::clamp((heat_n2_ / (rated * rated) - kFallsFrom) / (1.0 - kFallsFrom), 0.0, 1.0);
    const double low = std::min(kFallsTo * rated, peak);
    ceiling = std::sqrt(peak * peak + share * (low * low - peak * peak));
  }
  if (warm_ > 0.0) {
    const double warm = std::min(ceiling, reported_ceiling_n(settings));
    ceiling += warm_ * (warm - ceiling);
  }
  return ceiling;
}

} // namespace tactus::haptic

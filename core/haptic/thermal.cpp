#include "core/haptic/thermal.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::haptic {
namespace {
constexpr double kFallsFrom = 0.5; // share of continuous^2 at which the ceiling begins to fall
constexpr double kFallsTo = 0.9;   // share of continuous that it has fallen to at continuous^2
constexpr double kWarmShare = 0.5;
} // namespace

void ThermalLimit::advance(const ThermalSettings& settings, double force_n,
                           bool reported_warm) noexcept {
  const double kept = std::exp(-settings.period_s / kTimeConstant_s);
  heat_n2_ = kept * heat_n2_ + (1.0 - kept) * force_n * force_n;
  const double step = settings.period_s / (reported_warm ? kWarmRamp_s : -kCoolRamp_s);
  warm_ = std::clamp(warm_ + step, 0.0, 1.0);
}

double ThermalLimit::ceiling_n(const ThermalSettings& settings) const noexcept {
  const double peak = settings.peak_n;
  const double rated = settings.continuous_n;
  double ceiling = peak;
  if (rated > 0.0 && rated < peak) {
    const double share =
        std::clamp((heat_n2_ / (rated * rated) - kFallsFrom) / (1.0 - kFallsFrom), 0.0, 1.0);
    const double low = std::min(kFallsTo * rated, peak);
    ceiling = std::sqrt(peak * peak + share * (low * low - peak * peak));
  }
  if (warm_ > 0.0) {
    const double warm =
        std::min(ceiling, kWarmShare * (rated > 0.0 ? std::min(rated, peak) : peak));
    ceiling += warm_ * (warm - ceiling);
  }
  return ceiling;
}

} // namespace tactus::haptic

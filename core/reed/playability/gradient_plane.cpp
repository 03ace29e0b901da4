#include "core/reed/playability/gradient_plane.hpp"

#include "core/reed/playability/linear_stability.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {

ControlRange range_for(const Parameters& parameters) noexcept {
  const Parameters p = clamped(parameters);
  const bool closed = p.type == ValveType::kClosed;
  double highest = 1.25 * closing_pressure(p);
  if (!closed) {
    const LinearStability theory(p, p.length);
    const Threshold threshold = theory.threshold(p.reed_frequency);
    highest = threshold.found ? 5.6 * threshold.mouth_pressure
                              : theory.highest_pressure(p.reed_frequency);
  }
  constexpr double kStep = 100, kMaxPressure = 50e3;
  ControlRange range;
  range.highest_pressure =
      std::clamp(kStep * std::round(std::min(highest, kMaxPressure) / kStep), kStep, kMaxPressure);
  range.lowest_frequency = p.reed_frequency * (closed ? 0.4 : 0.25);
  range.highest_frequency = p.reed_frequency * (closed ? 1.4 : 2.75);
  return range;
}

} // namespace tactus::reed

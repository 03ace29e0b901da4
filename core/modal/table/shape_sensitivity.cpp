#include "core/modal/table/shape_sensitivity.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::modal {

std::vector<double> frequency_factors(const ShapeSensitivity& sensitivity,
                                      std::span<const double> frequency_hz,
                                      std::span<const double> displacement_m) {
  const std::size_t modes = frequency_hz.size();
  std::vector<double> factor(modes, 1);
  if (displacement_m.size() != sensitivity.parameters())
    return factor;
  const double highest = math::log(kMaxShapeFactor);
  for (std::size_t k = 0; k < modes; ++k) {
    double change = 0; // change of omega^2
    for (std::size_t p = 0; p < displacement_m.size(); ++p)
      change += sensitivity.eigenvalue_slope[p * modes + k] *
                (displacement_m[p] - sensitivity.solved_at(p));
    const double omega = 2 * std::numbers::pi * frequency_hz[k];
    const double exponent = 0.5 * change / (omega * omega);
    if (std::isfinite(exponent))
      factor[k] = math::exp(std::clamp(exponent, -highest, highest));
  }
  return factor;
}

} // namespace tactus::modal

#pragma once

#include "core/reed/bore/air.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <cmath>

namespace tactus::reed {

/// Coefficient G of exp(-G sqrt(s)), s^(1/2): viscous and thermal losses, and the dispersion that
/// comes with them, along the way to the end of the bore and back.
///   G = wall_loss * 2L (sqrt(nu) + (gamma - 1) sqrt(nu/Pr))/(c r_m)
/// (the first-order term of Kirchhoff's solution, right while the boundary layer is thin beside the
/// radius), r_m the radius, or a cone's logarithmic mean radius (r_1 - r)/ln(r_1/r).
[[nodiscard]] inline double wall_loss(const Parameters& p, double length,
                                      double sound_speed) noexcept {
  double radius = p.input_radius;
  if (p.shape == BoreShape::kCone) {
    const double growth = length / p.apex_distance;
    radius *= growth / std::log1p(growth);
  }
  return p.wall_loss * 2 * length *
         (std::sqrt(kKinematicViscosity) +
          (kHeatCapacityRatio - 1) * std::sqrt(kKinematicViscosity / kPrandtlNumber)) /
         (sound_speed * radius);
}

} // namespace tactus::reed

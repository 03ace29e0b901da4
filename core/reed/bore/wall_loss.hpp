#pragma once

#include "core/dsp/elementary.hpp"
#include "core/reed/bore/air.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <cmath>

namespace tactus::reed {

/// Coefficient G (s^(1/2)) of the wall loss exp(-G sqrt(s)): viscous and thermal attenuation and
/// dispersion over one round trip of a bore of this length (m).
///   G = wall_loss * 2L (sqrt(nu) + (gamma - 1) sqrt(nu/Pr))/(c r_m)
/// r_m is the radius, or for a cone its logarithmic mean (r_1 - r)/ln(r_1/r). This is the
/// first-order term of Kirchhoff's solution, valid while the boundary layer is thin relative to the
/// radius.
[[nodiscard]] inline double wall_loss(const Parameters& p, double length,
                                      double sound_speed) noexcept {
  double radius = p.input_radius;
  if (p.shape == BoreShape::kCone) {
    const double growth = length / p.apex_distance;
    radius *= growth / math::log1p(growth);
  }
  return p.wall_loss * 2 * length *
         (std::sqrt(kKinematicViscosity) +
          (kHeatCapacityRatio - 1) * std::sqrt(kKinematicViscosity / kPrandtlNumber)) /
         (sound_speed * radius);
}

} // namespace tactus::reed

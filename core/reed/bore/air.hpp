#pragma once

#include <cmath>

namespace tactus::reed {

/// Sound speed and density of dry air at atmospheric pressure.
struct Air {
  double sound_speed; // c, m/s
  double density;     // rho, kg/m^3
};

/// c = 331.45 sqrt(1 + t/273.15), rho = 1.2929 * 273.15/(273.15 + t), t in deg C, t > -273.15.
[[nodiscard]] inline Air air_at(double temperature_celsius) noexcept {
  constexpr double kZero = 273.15;
  return {331.45 * std::sqrt(1 + temperature_celsius / kZero),
          1.2929 * kZero / (kZero + temperature_celsius)};
}

// Constants of the viscous and thermal boundary layers at 20 deg C. Over 0..40 deg C the wall loss
// changes by less than 7 %, which is less than the effect of a wall's roughness.
inline constexpr double kKinematicViscosity = 1.51e-5; // nu, m^2/s
inline constexpr double kPrandtlNumber = 0.71;
inline constexpr double kHeatCapacityRatio = 1.402; // gamma of air

} // namespace tactus::reed

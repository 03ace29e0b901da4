#include "core/reed/radiation_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {

RadiationConstants RadiationConstants::from(const Parameters& p, const BoreDesign& bore,
                                            double internal_rate) noexcept {
  constexpr double kPi = std::numbers::pi;
  constexpr double kAtmosphere = 101325; // P_0, Pa
  RadiationConstants c;
  c.plain = !(p.bell > 0);
  c.rate = internal_rate;
  if (c.plain) {
    c.b0 = bore.air().density / bore.impedance() * internal_rate / (4 * kPi);
    c.b1 = -c.b0;
    return c;
  }
  const double speed = bore.air().sound_speed;
  const double cutoff = 2 * kPi * std::min(p.bell, 0.4 * internal_rate);
  const double opening = p.shape == BoreShape::kCone
                             ? p.input_radius * (1 + p.length / p.apex_distance)
                             : p.input_radius;
  const double corner = cutoff * opening / speed;              // over w_c
  const double k = 1 / std::tan(cutoff / (2 * internal_rate)); // s = w_c k (1 - z^-1)/(1 + z^-1)
  const double under = 1 + k * (k + 1 / p.bell_quality);
  const double over = 0.5 * p.input_radius * k / under;
  c.b0 = over * (k + corner);
  c.b1 = -2 * over * k;
  c.b2 = over * (k - corner);
  c.a1 = 2 * (1 - k * k) / under;
  c.a2 = (1 + k * (k - 1 / p.bell_quality)) / under;
  c.lead = (kHeatCapacityRatio + 1) / (2 * kHeatCapacityRatio * kAtmosphere * speed) *
           p.brassiness * internal_rate;
  return c;
}

RadiationConstants RadiationConstants::between(const RadiationConstants& from,
                                               const RadiationConstants& to,
                                               double share) noexcept {
  RadiationConstants c = to;
  for (double RadiationConstants::*member :
       {&RadiationConstants::b0, &RadiationConstants::b1, &RadiationConstants::b2,
        &RadiationConstants::a1, &RadiationConstants::a2, &RadiationConstants::lead})
    c.*member = from.*member + share * (to.*member - from.*member);
  return c;
}

} // namespace tactus::reed

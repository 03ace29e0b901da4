#include "core/reed/instrument/valve_constants.hpp"

#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

constexpr double kFastJet = 60; // m/s, jet velocity at a mouth pressure of 2 kPa

} // namespace

ValveConstants ValveConstants::from(const Parameters& p, const BoreDesign& bore,
                                    double internal_rate) noexcept {
  ValveConstants c;
  c.period = 1 / internal_rate;
  c.rate = internal_rate;
  c.swinging = p.type == ValveType::kSwinging;
  c.paper = p.flow == FlowMethod::kPaper;
  c.direction = !c.swinging && p.rest_angle < 0 ? -1 : 1;
  const double rest = p.arm_length * p.rest_angle * c.direction;
  // A valve whose rest position lies beyond its own limit is fixed there.
  c.rest_opening = std::fmin(std::fmax(rest, -p.displacement_limit), p.displacement_limit);
  c.lowest = (c.swinging ? -p.displacement_limit : 0) - c.rest_opening;
  c.highest = p.displacement_limit - c.rest_opening;
  c.width = p.width;
  c.leak = p.leak_area;
  c.mouth_area = c.direction * p.width * p.mouth_length;
  c.bore_area = c.direction * p.width * p.bore_length;
  c.swept_area = p.sweep ? c.bore_area : 0;
  c.flow_area = p.width * p.flow_length;
  c.mass = p.mass;
  c.damping = p.mass / p.quality;
  c.decay = 0.25 / (p.quality * p.quality);
  c.density = bore.air().density;
  c.specific_volume = 1 / c.density;
  c.channel_length = p.channel_length;
  // The jet settles at the rate u/lambda. Beyond 2/T the trapezoidal rule (theta = 1/2) rings, so
  // theta tends to 1 for short channels.
  const double steps = p.channel_length / (kFastJet * c.period), slow = 36 * steps * steps;
  const double theta = c.paper ? 1 : 0.5 + 0.5 / (1 + slow);
  c.jet_gain = 1 / theta;
  c.inertia = c.density * p.channel_length * internal_rate / theta;
  c.restitution = p.restitution;
  c.wave_admittance = 2 / bore.impedance();
  const double area = std::numbers::pi * p.input_radius * p.input_radius;
  if (p.shape == BoreShape::kCone)
    c.inertance_rate = c.period * area / (2 * c.density * p.apex_distance);
  c.compliance_rate = 2 * internal_rate * p.cup_volume /
                      (c.density * bore.air().sound_speed * bore.air().sound_speed);
  c.port_admittance = 1 / bore.impedance() + c.inertance_rate + c.compliance_rate;
  c.rigid_impedance = 1 / c.port_admittance;
  c.angle_scale = c.direction / p.arm_length;
  return c;
}

ValveConstants ValveConstants::interpolate(const ValveConstants& from, const ValveConstants& to,
                                           double share) noexcept {
  ValveConstants c = to;
  for (double ValveConstants::*member : {&ValveConstants::rest_opening,
                                         &ValveConstants::lowest,
                                         &ValveConstants::highest,
                                         &ValveConstants::width,
                                         &ValveConstants::leak,
                                         &ValveConstants::mouth_area,
                                         &ValveConstants::bore_area,
                                         &ValveConstants::swept_area,
                                         &ValveConstants::flow_area,
                                         &ValveConstants::mass,
                                         &ValveConstants::damping,
                                         &ValveConstants::decay,
                                         &ValveConstants::density,
                                         &ValveConstants::specific_volume,
                                         &ValveConstants::inertia,
                                         &ValveConstants::jet_gain,
                                         &ValveConstants::channel_length,
                                         &ValveConstants::restitution,
                                         &ValveConstants::wave_admittance,
                                         &ValveConstants::port_admittance,
                                         &ValveConstants::inertance_rate,
                                         &ValveConstants::compliance_rate,
                                         &ValveConstants::angle_scale})
    c.*member = from.*member + share * (to.*member - from.*member);
  c.rigid_impedance = 1 / c.port_admittance;
  return c;
}

} // namespace tactus::reed

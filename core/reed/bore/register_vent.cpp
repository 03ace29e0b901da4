#include "core/reed/bore/register_vent.hpp"

#include "core/reed/bore/air.hpp"
#include "core/reed/bore/radiation.hpp"
#include "core/reed/bore/woodwind.hpp"

#include <cmath>
#include <numbers>

namespace tactus::reed {

RegisterVent RegisterVent::of(const Parameters& parameters) noexcept {
  constexpr double kPi = std::numbers::pi, kInner = 0.82; // kInner: share of the radius; a hole far
                                                          // narrower than the bore (Nederveen et
                                                          // al. 1998)
  RegisterVent vent;
  const Woodwind* const instrument = woodwind(parameters.end);
  if (instrument == nullptr)
    return vent;
  const Woodwind::Hole& hole = instrument->vent;
  const Air air = air_at(parameters.temperature);
  const double bore =
      parameters.input_radius *
      (parameters.shape == BoreShape::kCone ? 1 + hole.position / parameters.apex_distance : 1);
  const double impedance = air.density * air.sound_speed / (kPi * bore * bore);
  const double area = kPi * hole.radius * hole.radius, omega = 2 * kPi * kFrictionFrequency_hz;
  const double friction = air.density * hole.height / area * 2 / hole.radius *
                          std::sqrt(kKinematicViscosity * omega / 2);
  const double length = hole.height + (kInner + OpenEnd::kLengthCorrection) * hole.radius;
  const double mass = air.density * length / area + friction / omega;
  vent.position = hole.position;
  vent.share = impedance / (impedance + 2 * friction);
  vent.corner = (impedance + 2 * friction) / (2 * mass);
  const double separation = kSeparation * air.density / (2 * area * area);
  vent.separation = vent.share * 2 / impedance * separation * 2 / impedance;
  return vent;
}

} // namespace tactus::reed

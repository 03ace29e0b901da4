#include "core/contact/friction.hpp"

#include <cmath>
#include <numbers>

namespace tactus::contact {
FrictionLaw FrictionLaw::within_range() const noexcept {
  const FrictionLaw defaults;
  FrictionLaw law;
  law.dynamic_coefficient = within(dynamic_coefficient, 1e-6, 100, defaults.dynamic_coefficient);
  law.static_coefficient = std::max(
      within(static_coefficient, 1e-6, 100, defaults.static_coefficient), law.dynamic_coefficient);
  law.stribeck_m_per_s = within(stribeck_m_per_s, 1e-6, 1e3, defaults.stribeck_m_per_s);
  law.breakaway = within(breakaway, 1e-3, 0.99, defaults.breakaway);
  law.stiffness_n_per_m = within(stiffness_n_per_m, 1, 1e12, defaults.stiffness_n_per_m);
  law.damping_ns_per_m = within(damping_ns_per_m, 0, 1e9, defaults.damping_ns_per_m);
  law.viscosity_ns_per_m = within(viscosity_ns_per_m, 0, 1e9, defaults.viscosity_ns_per_m);
  law.roughness = within(roughness, 0, 1e3, defaults.roughness);
  return law;
}

void Friction::set(const FrictionLaw& law) noexcept {
  const double before = law_.stiffness_n_per_m;
  law_ = law.within_range();
  // A larger stiffness must not add energy, so the bristles keep their energy k z^2 / 2.
  if (law_.stiffness_n_per_m > before)
    bend_ *= std::sqrt(before / law_.stiffness_n_per_m);
  const double softness = 1 / law_.stiffness_n_per_m;
  dynamic_over_stiffness_ = law_.dynamic_coefficient * softness;
  excess_over_stiffness_ = (law_.static_coefficient - law_.dynamic_coefficient) * softness;
  ratio_ = kUnsetRatio;
  inverse_stribeck_ = std::sqrt(std::numbers::log2e) / law_.stribeck_m_per_s;
}

} // namespace tactus::contact

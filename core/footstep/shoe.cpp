#include "core/footstep/shoe.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>

namespace tactus::footstep {
namespace {

constexpr double kReferenceIndentation = 1e-3;                      // m
constexpr double kBarefootForce = 63, kSteelForce = 1.6e5;          // N
constexpr double kBarefootDissipation = 3, kSteelDissipation = 0.3; // s/m

double between(double soft, double hard, double hardness) noexcept {
  return soft * math::pow(hard / soft, hardness);
}

} // namespace

contact::ImpactLaw sole_law(double hardness, double exponent) noexcept {
  hardness = std::clamp(hardness, 0.0, 1.0);
  contact::ImpactLaw law;
  law.exponent = exponent;
  law.stiffness =
      between(kBarefootForce, kSteelForce, hardness) / math::pow(kReferenceIndentation, exponent);
  law.dissipation_s_per_m = between(kBarefootDissipation, kSteelDissipation, hardness);
  return law;
}

contact::ImpactLaw in_series(const contact::ImpactLaw& ground,
                             const contact::ImpactLaw& sole) noexcept {
  const double a = ground.exponent;
  const double ground_compliance = math::pow(ground.stiffness, -1 / a);
  const double sole_compliance = math::pow(sole.stiffness, -1 / a);
  const double compliance = ground_compliance + sole_compliance;
  const double ground_share = ground_compliance / compliance,
               sole_share = sole_compliance / compliance;
  contact::ImpactLaw law = ground;
  law.stiffness = math::pow(compliance, -a);
  law.dissipation_s_per_m = ground_share * ground_share * ground.dissipation_s_per_m +
                            sole_share * sole_share * sole.dissipation_s_per_m;
  return law;
}

} // namespace tactus::footstep

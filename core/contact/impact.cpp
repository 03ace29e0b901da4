#include "core/contact/impact.hpp"

#include <cmath>

namespace tactus::contact {
ImpactLaw ImpactLaw::within_range() const noexcept {
  const ImpactLaw usual;
  return {within(stiffness, 1e-3, 1e18, usual.stiffness), within(exponent, 1, 6, usual.exponent),
          within(dissipation_s_per_m, 0, 1e6, usual.dissipation_s_per_m)};
}

double ImpactLaw::force(double x, double v) const noexcept {
  if (!(x > 0))
    return 0;
  return std::max(stiffness * std::pow(x, exponent) * (1 + dissipation_s_per_m * v), 0.0);
}

double ImpactLaw::work(double x) const noexcept {
  return x > 0 ? stiffness / (exponent + 1) * std::pow(x, exponent + 1) : 0.0;
}

double ImpactLaw::deepest(double work_j) const noexcept {
  return work_j > 0 ? std::pow((exponent + 1) * work_j / stiffness, 1 / (exponent + 1)) : 0.0;
}

double restitution(double y) noexcept {
  if (!(y > 1e-4)) // the series of what follows; its next term is below 1e-12
    return y > 0 ? 1 - y * (2.0 / 3 - y * (4.0 / 9)) : 1.0;
  // With t = -ln(1 - e y) the equation is t - 1 + exp(-t) = y - ln(1 + y). Its left side grows and
  // bends upwards, so Newton's method from above comes down to the root without passing it.
  const double kept = y - std::log1p(y);
  double t = kept + std::sqrt(2 * kept);
  for (int round = 0; round < 60; ++round) {
    const double rest = -std::expm1(-t); // 1 - exp(-t)
    const double step = (t - rest - kept) / rest;
    t -= step;
    if (!(std::abs(step) > 1e-14 * t))
      break;
  }
  return -std::expm1(-t) / y;
}

void Impact::set(const ImpactLaw& law) noexcept {
  law_ = law.within_range();
  const double k = law_.stiffness, a = law_.exponent;
  power_ = FollowedPower(0.5 * (a - 1));
  gamma_scale_ = std::sqrt(0.5 * k * (a + 1));
  psi_scale_ = std::sqrt(2 * k / (a + 1));
  loss_scale_ = k * law_.dissipation_s_per_m;
  rate_power_ = Power((a - 1) / (a + 1));
  rate_scale_ = a * k * std::pow((a + 1) / k, (a - 1) / (a + 1));
}

} // namespace tactus::contact

#include "core/contact/impact.hpp"

#include "core/contact/pressed_contacts.hpp"
#include "core/dsp/elementary.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace tactus::contact {
namespace {

constexpr int kMaxIterations = 60;
constexpr double kTolerance = 1e-13; // relative to the penetration

} // namespace

ImpactLaw ImpactLaw::within_range() const noexcept {
  const ImpactLaw defaults;
  return {within(stiffness, 1e-3, 1e18, defaults.stiffness),
          within(exponent, 1, 6, defaults.exponent),
          within(dissipation_s_per_m, 0, 1e6, defaults.dissipation_s_per_m),
          within(compliance_m_per_n, 0, 1e6, 0)};
}

double ImpactLaw::indentation(double x) const noexcept {
  if (!(compliance_m_per_n > 0) || !(x > 0))
    return std::max(x, 0.0);
  // x = d + C k d^a: the right side grows with d and bends upwards, so Newton's method from above
  // always converges.
  double d = x;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const double give = compliance_m_per_n * stiffness * math::pow(d, exponent);
    const double step = (d + give - x) / (1 + exponent * give / d);
    d -= step;
    if (!(step > kTolerance * x) || !(d > 0))
      break;
  }
  return std::max(d, 0.0);
}

double ImpactLaw::force(double x, double v) const noexcept {
  if (!(x > 0))
    return 0;
  return std::max(stiffness * math::pow(indentation(x), exponent) * (1 + dissipation_s_per_m * v),
                  0.0);
}

double ImpactLaw::work(double x) const noexcept {
  if (!(x > 0))
    return 0;
  const double d = indentation(x), force = stiffness * math::pow(d, exponent);
  return force * d / (exponent + 1) + 0.5 * compliance_m_per_n * force * force;
}

double ImpactLaw::deepest(double work_j) const noexcept {
  if (!(work_j > 0))
    return 0;
  const double alone = math::pow((exponent + 1) * work_j / stiffness, 1 / (exponent + 1));
  if (!(compliance_m_per_n > 0))
    return alone;
  // The stored work is convex in x and its slope is the force, so Newton's method from above
  // converges.
  double x = alone + std::sqrt(2 * work_j * compliance_m_per_n);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const double step = (work(x) - work_j) / force(x, 0);
    if (!(step > kTolerance * x))
      break;
    x -= step;
  }
  return x;
}

double ImpactLaw::duration(double mass_kg, double speed_m_per_s) const noexcept {
  const double b = 1 / (exponent + 1);
  const double integral = std::sqrt(std::numbers::pi) * math::tgamma(1 + b) / math::tgamma(0.5 + b);
  const double energy = 0.5 * mass_kg * speed_m_per_s * speed_m_per_s;
  const double deepest = math::pow((exponent + 1) * energy / stiffness, b);
  return 2 * deepest / speed_m_per_s * integral;
}

double hertz_stiffness(double radius_m, double modulus_pa, double poisson, double other_modulus_pa,
                       double other_poisson) noexcept {
  const double softness =
      (1 - poisson * poisson) / modulus_pa + (1 - other_poisson * other_poisson) / other_modulus_pa;
  return 4.0 / 3.0 * std::sqrt(radius_m) / softness;
}

double restitution(double y) noexcept {
  if (!(y > 1e-4)) // a series; its next term is below 1e-12
    return y > 0 ? 1 - y * (2.0 / 3 - y * (4.0 / 9)) : 1.0;
  // With t = -ln(1 - e y) the equation is t - 1 + exp(-t) = y - ln(1 + y). Its left side grows and
  // bends upwards, so Newton's method from above comes down to the root without passing it.
  const double kept = y - math::log1p(y);
  double t = kept + std::sqrt(2 * kept);
  for (int iteration = 0; iteration < 60; ++iteration) {
    const double slope = -math::expm1(-t); // 1 - exp(-t)
    const double step = (t - slope - kept) / slope;
    t -= step;
    if (!(std::abs(step) > 1e-14 * t))
      break;
  }
  return -math::expm1(-t) / y;
}

double dissipation_for(double restitution, double speed_m_per_s) noexcept {
  if (restitution >= 1)
    return 0;
  const double e = std::max(restitution, 0.01);
  // (1 + y)/(1 - e y) = exp(y (1 + e)) with y = mu v between 0 and 1/e; the difference of both
  // sides changes sign once in between.
  double low = 1e-9, high = (1 - 1e-12) / e;
  for (int iteration = 0; iteration < 100; ++iteration) {
    const double y = 0.5 * (low + high);
    (math::log((1 + y) / (1 - e * y)) < y * (1 + e) ? low : high) = y;
  }
  return 0.5 * (low + high) / speed_m_per_s;
}

void Impact::set(const ImpactLaw& law) noexcept {
  law_ = law.within_range();
  const double k = law_.stiffness, a = law_.exponent;
  power_ = TaylorPower(0.5 * (a - 1));
  gamma_scale_ = std::sqrt(0.5 * k * (a + 1));
  psi_scale_ = std::sqrt(2 * k / (a + 1));
  loss_scale_ = k * law_.dissipation_s_per_m;
  rate_power_ = Power((a - 1) / (a + 1));
  rate_scale_ = a * k * math::pow((a + 1) / k, (a - 1) / (a + 1));
}

Impact::ElasticState Impact::relax(double x) noexcept {
  // Solves x = d + C k d^a by Newton's method, started at the last solution. After one iteration it
  // converges from above, as in ImpactLaw::indentation().
  const double a = law_.exponent, c = law_.compliance_m_per_n, k = law_.stiffness;
  double d = indentation_ > 0 && indentation_ < x ? indentation_ : x, force = 0;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const double power = power_(d);
    force = k * d * power * power;
    const double step = (d + c * force - x) / (1 + a * c * k * power * power);
    d = within_reach(d - step < x ? d - step : x);
    if (!(std::abs(step) > 1e-10 * x))
      break;
  }
  const double power = power_(d);
  force = k * d * power * power;
  indentation_ = d;
  return {force, std::sqrt(2 * force * d / (a + 1) + c * force * force)};
}

LinearForce Impact::enter_compliant_step(double x, double travel, double h) noexcept {
  const double end = x + travel;
  if (x > 0 && end > 0) {
    const ElasticState middle = relax(within_reach(x + 0.5 * travel));
    gamma_ = middle.force_n / middle.psi; // psi*' = F/psi*
    return {gamma_ * psi_, 0.5 * h * gamma_ * gamma_ + law_.dissipation_s_per_m * middle.force_n};
  }
  return x <= 0 ? begin_contact(relax(within_reach(end)).psi, travel, h) : end_contact(travel, h);
}

void Impact::store_to_lane(PressedBlock& b, std::size_t l) const noexcept {
  b.psi[l] = psi_;
  b.energy_account[l] = energy_account_j_;
  b.gamma_scale[l] = gamma_scale_;
  b.psi_scale[l] = psi_scale_;
  b.loss_scale[l] = loss_scale_;
  const auto [value, inverse] = power_.anchor();
  b.exponent[l] = power_.exponent();
  const bool constant = power_.exponent() == 0; // 1 at any depth
  b.power_value[l] = constant ? 1 : value;
  b.power_inverse[l] = constant ? 1 : inverse;
  b.power_limit[l] = constant ? std::numeric_limits<double>::infinity() : TaylorPower::kReach;
  for (int k = 0; k < TaylorPower::kTerms; ++k)
    b.power_term[static_cast<std::size_t>(k)][l] = constant ? 0 : power_.term(k);
}

void Impact::load_from_lane(const PressedBlock& b, std::size_t l) noexcept {
  psi_ = b.psi[l];
  energy_account_j_ = b.energy_account[l];
  if (power_.exponent() != 0)
    power_.set_anchor({b.power_value[l], b.power_inverse[l]});
}

} // namespace tactus::contact

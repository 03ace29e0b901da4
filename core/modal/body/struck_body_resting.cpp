#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <cmath>

/// StruckBody: a body that rests on a board.
namespace tactus::modal {

std::size_t StruckBody::active_strikes() const noexcept {
  const std::size_t active = model_->solver.active();
  return in_solver_ ? active - std::min(active, model_->resting_contacts.size()) : active;
}

/// Begins all resting contacts at the bodies' present positions.
void StruckBody::begin_resting_contacts() noexcept {
  BodyModel& m = *model_;
  for (std::size_t i = 0; i < m.resting_contacts.size(); ++i) {
    const BodyModel::RestingContact& rest = m.resting_contacts[i];
    m.solver.begin_resting_contact(m.resting_slot() + i, {rest.law, rest.preload_n}, rest.gain,
                                   rest.rigid);
  }
}

/// True if nothing but the board touches the body and its motion is about a millionth of the static
/// deflection (less for a gain above kReferenceGain). The body is then set to rest and costs
/// nothing until something moves it again.
bool StruckBody::has_settled() const noexcept {
  constexpr double kEnergyShare = 1e-12, kMinEnergy = 1e-18; // of energies; J
  constexpr double kForceShare = 1e-6;                       // of the weight on all points
  constexpr double kReferenceGain = 0.01;                    // 1/Pa
  const BodyModel& m = *model_;
  if (!has_resting_contacts() || active_strikes() > 0)
    return false;
  const double gain_ratio = std::min(kReferenceGain / std::max(options_.gain, 1e-6), 1.0);
  double stored = 0, load = 0, largest = 0;
  for (std::size_t i = 0; i < m.resting_contacts.size(); ++i) {
    const BodyModel::RestingContact& rest = m.resting_contacts[i];
    stored += rest.preload_n * m.solver.contact(m.resting_slot() + i).exciter.position_m;
    load += rest.preload_n;
    largest = std::max(largest, std::abs(m.solver.net_contact_force(m.resting_slot() + i)));
  }
  if (largest > kForceShare * gain_ratio * load)
    return false;
  const double threshold = std::max(kEnergyShare * stored, kMinEnergy) * gain_ratio * gain_ratio;
  double energy = m.solver.rigid_energy();
  for (std::size_t k = 0; k < m.mode.size() && energy <= threshold; ++k)
    energy += 0.5 * std::norm(m.solver.state(k));
  return energy <= threshold;
}

} // namespace tactus::modal

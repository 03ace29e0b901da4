#include "core/dsp/complex.hpp"
#include "core/modal/body/body_model.hpp"

#include <algorithm>
#include <cmath>

/// BodyModel: the motion between bank and solver.
namespace tactus::modal {

void BodyModel::enter_contact() noexcept {
  if (in_solver)
    return;
  in_solver = true;
  const auto states = std::span(scratch_state).first(audible_modes);
  bank.read_states(states);
  solver.write_states(states);
  bank.silence();
  if (rests())
    solver.reset_rigid();
  begin_resting_contacts();
}

void BodyModel::leave_contact(double gain, double cull_db) noexcept {
  if (!in_solver)
    return;
  const bool settled = has_settled(gain);
  in_solver = false;
  for (std::size_t i = 0; i < resting_slot() + resting_contacts.size(); ++i)
    solver.end(i);
  const auto states = std::span(scratch_state).first(audible_modes);
  solver.read_states(states);
  if (settled)
    std::fill(states.begin(), states.end(), 0.0);
  if (!bank.idle()) {
    bank.read_states(bank_state);
    for (std::size_t k = 0; k < audible_modes; ++k)
      states[k] += bank_state[k];
  }
  double loudest = 0, strongest = 0;
  for (std::size_t k = 0; k < audible_modes; ++k) { // squared loudness
    scratch[k] = loudness[k] * loudness[k] * math::norm(states[k]);
    loudest = std::max(loudest, scratch[k]);
    strongest = std::max(strongest, math::norm(states[k]));
  }
  // A mode that the listeners do not hear may still move the surface under the next striker.
  const double share = math::exp10(-cull_db / 10);
  culled = 0;
  for (std::size_t k = 0; k < audible_modes; ++k)
    if (scratch[k] < share * loudest && math::norm(states[k]) < share * strongest) {
      ++culled;
      states[k] = 0;
    }
  bank.write_states(states);
}

std::size_t BodyModel::active_strikes() const noexcept {
  const std::size_t active = solver.active();
  return in_solver ? active - std::min(active, resting_contacts.size()) : active;
}

/// Begins all resting contacts at the bodies' present positions.
void BodyModel::begin_resting_contacts() noexcept {
  for (std::size_t i = 0; i < resting_contacts.size(); ++i) {
    const RestingContact& rest = resting_contacts[i];
    solver.begin_resting_contact(resting_slot() + i, {rest.law, rest.preload_n}, rest.gain,
                                 rest.rigid);
  }
}

/// A settled body is set to rest and costs nothing until something moves it again.
bool BodyModel::has_settled(double gain) const noexcept {
  constexpr double kEnergyShare = 1e-12, kMinEnergy = 1e-18; // share of energies; J
  constexpr double kForceShare = 1e-6;                       // share of the weight on all points
  constexpr double kReferenceGain = 0.01;                    // 1/Pa
  if (!rests() || active_strikes() > 0)
    return false;
  const double gain_ratio = std::min(kReferenceGain / std::max(gain, 1e-6), 1.0);
  double stored = 0, load = 0, largest = 0;
  for (std::size_t i = 0; i < resting_contacts.size(); ++i) {
    const RestingContact& rest = resting_contacts[i];
    stored += rest.preload_n * solver.contact(resting_slot() + i).exciter.position_m;
    load += rest.preload_n;
    largest = std::max(largest, std::abs(solver.net_contact_force(resting_slot() + i)));
  }
  if (largest > kForceShare * gain_ratio * load)
    return false;
  const double threshold = std::max(kEnergyShare * stored, kMinEnergy) * gain_ratio * gain_ratio;
  double energy = solver.rigid_energy();
  for (std::size_t k = 0; k < mode.size() && energy <= threshold; ++k)
    energy += 0.5 * math::norm(solver.state(k));
  return energy <= threshold;
}

} // namespace tactus::modal

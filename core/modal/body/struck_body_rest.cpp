#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <cmath>

/// How a StruckBody rests on a board.
namespace tactus::modal {

std::size_t StruckBody::active_besides_rests() const noexcept {
  const std::size_t active = model_->solver.active();
  return coupled_now_ ? active - std::min(active, model_->rests.size()) : active;
}

/// From where the two bodies are.
void StruckBody::begin_rests() noexcept {
  BodyModel& m = *model_;
  for (std::size_t i = 0; i < m.rests.size(); ++i) {
    const BodyModel::Rest& rest = m.rests[i];
    m.solver.begin_rest(m.rest_slot() + i, {rest.law, rest.preload_n}, rest.gain, rest.rigid);
  }
}

/// Nothing touches the two bodies but each other, and what is left of their motion is a millionth
/// of what their rest bends them by, in a louder object less: it ends there, and costs nothing
/// until something moves them again.
bool StruckBody::has_settled() const noexcept {
  constexpr double kShare = 1e-12, kLeast = 1e-18; // of energies; J
  constexpr double kForceShare = 1e-6;             // of the weight on all points
  constexpr double kUsualGain = 0.01;              // 1/Pa
  const BodyModel& m = *model_;
  if (!rests() || active_besides_rests() > 0)
    return false;
  const double quieter = std::min(kUsualGain / std::max(options_.gain, 1e-6), 1.0);
  double stored = 0, carried = 0, largest = 0;
  for (std::size_t i = 0; i < m.rests.size(); ++i) {
    const BodyModel::Rest& rest = m.rests[i];
    stored += rest.preload_n * m.solver.contact(m.rest_slot() + i).exciter.place_m;
    carried += rest.preload_n;
    largest = std::max(largest, std::abs(m.solver.unbalanced(m.rest_slot() + i)));
  }
  if (largest > kForceShare * quieter * carried)
    return false;
  const double least = std::max(kShare * stored, kLeast) * quieter * quieter;
  double energy = m.solver.rigid_energy();
  for (std::size_t k = 0; k < m.mode.size() && energy <= least; ++k)
    energy += 0.5 * std::norm(m.solver.state(k));
  return energy <= least;
}

} // namespace tactus::modal

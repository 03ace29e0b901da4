#include "core/modal/body/body_model.hpp"

#include <algorithm>
#include <cmath>

/// BodyModel: continuing the motion in a table whose modes were solved again.
///
/// With modal mass 1 and z = q' + alpha q + j omega q, a mode's energy is |z|^2/2 and its output is
/// Im(w z). The table's shares T are a partial isometry (ModeShare). At the sample of the exchange
///   z_now = T z_before,  w_now = T w_before,  z_left = z_before - T' z_now
/// conserve the energy, |z_now|^2 + |z_left|^2 = |z_before|^2, and the sound,
/// w_now' z_now + w_before' z_left = w_before' z_before. From then on each mode rings at its new
/// rate, w_now glides to the new table's weights, and z_left fades out.
namespace tactus::modal {
namespace {

constexpr double kNegligibleEnergy = 1e-12; // of the total: -120 dB

} // namespace

bool BodyModel::continue_modes_from(BodyModel& before, bool in_contact_now) noexcept {
  // During a contact the bank may still ring from pulses; that fades out too.
  const std::size_t old_count = in_contact_now ? before.mode.size() : before.audible_modes;
  const auto old_states = std::span(before.scratch_state).first(old_count);
  const bool bank_ringing =
      before.bank.release_left() > 0 || (in_contact_now && before.bank.ringing());
  if (in_contact_now)
    before.solver.read_states(old_states);
  else
    before.bank.read_states(old_states);
  const std::size_t count = in_contact_now ? mode.size() : audible_modes;
  const auto states = std::span(scratch_state).first(count);
  std::fill(states.begin(), states.end(), 0.0);
  double total_energy = 0, lost_energy = 0; // times 2, J
  for (const std::complex<double>& z : old_states)
    total_energy += std::norm(z);
  const auto for_shares = [&](auto&& work) {
    for (const ModeShare& s : loaded->share) {
      const std::size_t i = index_of[s.now], j = before.index_of[s.before];
      if (i < count && j < old_count)
        work(i, j, s.share);
    }
  };
  for_shares(
      [&](std::size_t i, std::size_t j, double share) { states[i] += share * old_states[j]; });
  for_shares(
      [&](std::size_t i, std::size_t j, double share) { old_states[j] -= share * states[i]; });
  for (std::size_t j = 0; j < before.audible_modes; ++j)
    lost_energy += std::norm(before.scratch_state[j]);
  if (in_contact_now) {
    solver.write_states(states);
    const double length_ratio = settings.size / before.settings.size;
    solver.take_over_rigid(before.solver, before.mass_kg > 0 ? mass_kg / before.mass_kg : 1,
                           length_ratio);
    if (!resting_contacts.empty())
      solver.project_rigid(rigid_basis_);
  } else {
    bank.write_states(states);
  }
  glide_by_shares(before);
  if (!bank_ringing && lost_energy <= kNegligibleEnergy * total_energy) {
    before.bank.silence();
    return false;
  }
  if (in_contact_now)
    before.bank.release(); // modes that pulses have excited
  before.bank.write_states(std::span(before.scratch_state).first(before.audible_modes));
  before.bank.release();
  return true;
}

void BodyModel::glide_by_shares(BodyModel& before) noexcept {
  bank.set_clock(before.bank.clock());
  const std::size_t listeners = std::min(settings.listeners, before.settings.listeners);
  for (std::size_t l = 0; l < listeners; ++l) {
    for (const auto part : {ModeBank::kOld, ModeBank::kMiddle, ModeBank::kLatest}) {
      auto& w = scratch_weight_[part];
      std::fill(w.begin(), w.end(), 0.0);
      std::fill_n(scratch.begin(), audible_modes, 0.0); // sums of squared shares
      for (const ModeShare& s : loaded->share) {
        const std::size_t i = index_of[s.now], j = before.index_of[s.before];
        if (i >= audible_modes || j >= before.audible_modes)
          continue;
        w[i] += s.share * before.bank.weight(l, part, j);
        scratch[i] += s.share * s.share;
      }
      for (std::size_t i = 0; i < audible_modes; ++i) // modes without a predecessor
        if (scratch[i] == 0)
          w[i] = weight[l][i];
    }
    bank.set_glide(l, before.bank.glide(l),
                   {scratch_weight_[0], scratch_weight_[1], scratch_weight_[2]});
  }
  for (std::size_t l = listeners; l < settings.listeners; ++l)
    bank.set_glide(l, before.bank.glide(0), {weight[l], weight[l], weight[l]});
  bank.set_weights(std::span(weight).first(settings.listeners));
}

} // namespace tactus::modal

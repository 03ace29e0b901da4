#include "core/modal/body/body_model.hpp"

#include <algorithm>
#include <cmath>

/// How a body that has been solved anew goes on ringing where it was.
///
/// With z = q' + alpha q + j omega q of modal mass 1 a mode's energy is |z|^2/2, and it is heard as
/// Im(w z), w its weight at a listener. The shares T of the table are a partial isometry (see
/// ModeShare), so that
///   z_now = T z_before,  w_now = T w_before  and  z_left = z_before - T' z_now
/// keep the energy, |z_now|^2 + |z_left|^2 = |z_before|^2, and the sound, w_now' z_now +
/// w_before' z_left = w_before' z_before, at the sample of the exchange; then each mode swings at
/// its new rate, w_now glides to the new table's weights, and z_left is faded out.
namespace tactus::modal {
namespace {

constexpr double kNothingLeft = 1e-12; // of the energy: -120 dB

} // namespace

bool BodyModel::succeed(BodyModel& before, bool touched) noexcept {
  // Beside a contact the bank rings with what is left of crowded strikes: that is faded out too.
  const std::size_t old_count = touched ? before.mode.size() : before.heard;
  const auto old_states = std::span(before.scratch_state).first(old_count);
  const bool rings_beside = before.bank.release_left() > 0 || (touched && before.bank.rings());
  if (touched)
    before.solver.read_states(old_states);
  else
    before.bank.read_states(old_states);
  const std::size_t count = touched ? mode.size() : heard;
  const auto states = std::span(scratch_state).first(count);
  std::fill(states.begin(), states.end(), 0.0);
  double whole = 0, left = 0; // energies
  for (const std::complex<double>& z : old_states)
    whole += std::norm(z);
  const auto for_shares = [&](auto&& work) {
    for (const ModeShare& s : loaded->share) {
      const std::size_t i = place_of[s.now], j = before.place_of[s.before];
      if (i < count && j < old_count)
        work(i, j, s.share);
    }
  };
  for_shares(
      [&](std::size_t i, std::size_t j, double share) { states[i] += share * old_states[j]; });
  for_shares(
      [&](std::size_t i, std::size_t j, double share) { old_states[j] -= share * states[i]; });
  for (std::size_t j = 0; j < before.heard; ++j)
    left += std::norm(before.scratch_state[j]);
  if (touched) {
    solver.write_states(states);
    const double longer = settings.size / before.settings.size;
    solver.take_over_rigid(before.solver, before.mass_kg > 0 ? mass_kg / before.mass_kg : 1,
                           longer);
    if (!rests.empty())
      solver.constrain_rigid(rigid_basis_);
  } else {
    bank.write_states(states);
  }
  glide_by_shares(before);
  if (!rings_beside && left <= kNothingLeft * whole) {
    before.bank.silence();
    return false;
  }
  if (touched)
    before.bank.release(); // what rings beside
  before.bank.write_states(std::span(before.scratch_state).first(before.heard));
  before.bank.release();
  return true;
}

void BodyModel::glide_by_shares(BodyModel& before) noexcept {
  bank.set_clock(before.bank.clock());
  const std::size_t listeners = std::min(settings.listeners, before.settings.listeners);
  for (std::size_t l = 0; l < listeners; ++l) {
    for (const auto part : {ModeBank::kOld, ModeBank::kMiddle, ModeBank::kFresh}) {
      auto& w = scratch_weight_[part];
      std::fill(w.begin(), w.end(), 0.0);
      std::fill_n(scratch.begin(), heard, 0.0); // of the shares' squares
      for (const ModeShare& s : loaded->share) {
        const std::size_t i = place_of[s.now], j = before.place_of[s.before];
        if (i >= heard || j >= before.heard)
          continue;
        w[i] += s.share * before.bank.weight(l, part, j);
        scratch[i] += s.share * s.share;
      }
      for (std::size_t i = 0; i < heard; ++i) // a mode that is new is heard as it is
        if (scratch[i] == 0)
          w[i] = weight[l][i];
    }
    bank.take_glide(l, before.bank.glide(l),
                    {scratch_weight_[0], scratch_weight_[1], scratch_weight_[2]});
  }
  for (std::size_t l = listeners; l < settings.listeners; ++l)
    bank.take_glide(l, before.bank.glide(0), {weight[l], weight[l], weight[l]});
  bank.set_weights(std::span(weight).first(settings.listeners));
}

} // namespace tactus::modal

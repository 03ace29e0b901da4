#include "core/dsp/complex.hpp"
#include "core/modal/body/body_model.hpp"

#include <algorithm>
#include <cmath>

/// BodyModel: continuing the motion of an earlier model of the same body.
namespace tactus::modal {
namespace {

constexpr double kNegligibleEnergy = 1e-12; // share of the total: -120 dB

} // namespace

bool BodyModel::continue_from(BodyModel& before) noexcept {
  in_solver = before.in_solver;
  bool left_over = false;
  if (loaded->follows(*before.loaded))
    left_over = continue_by_shares(before);
  else if (in_solver)
    continue_in_contact(before);
  else
    continue_in_bank(before);
  if (!in_solver)
    return left_over;
  if (rests() && !before.rests())
    solver.reset_rigid(); // the present position is the equilibrium on the new board
  begin_resting_contacts();
  return left_over;
}

void BodyModel::take_over_contact(std::size_t slot, const BodyModel& before, std::size_t old_slot,
                                  const SurfacePoint& point, const Vec3& direction,
                                  bool held) noexcept {
  if (!before.solver.contact(old_slot).active)
    return;
  gains(point, direction, scratch);
  const RigidGain rigid = held && !recoils(point) ? RigidGain{} : rigid_gains(point, direction);
  solver.take_over(slot, before.solver, old_slot, scratch, rigid);
  build_contact_kernels(slot, point, direction);
}

/// The deflection of a mode of the present solver under the present contact forces, as a state z =
/// -b F/s, limited to the part of it that the mode's state contains.
Complex BodyModel::pressed_state(std::size_t i) const noexcept {
  const Complex pressed = -solver.modal_force(i) / rate[i], z = scratch_state[i];
  const double square = math::norm(pressed);
  return square > 0 ? std::clamp((z * math::conj(pressed)).real() / square, 0.0, 1.0) * pressed
                    : 0.0;
}

/// Ratio of the deflection of mode i by a force to the deflection of the same mode in the earlier
/// model, where its index is j.
Complex BodyModel::deflection_ratio(std::size_t i, const BodyModel& before,
                                    std::size_t j) const noexcept {
  const std::size_t part = loaded->is_board_mode(mode[i]) ? LoadedTable::kBoard : 0;
  return shape_scale_of(part) / before.shape_scale_of(part) * before.rate[j] / rate[i];
}

void BodyModel::release_from(BodyModel& before) noexcept {
  if (before.bank.release_left() == 0)
    return;
  before.bank.read_released(std::span(before.scratch_state).first(before.audible_modes));
  bank.write_released(keep_states(before, audible_modes, before.audible_modes),
                      before.bank.release_left());
}

/// The states of another model's modes, from its scratch_state, in the order of this model's modes.
std::span<Complex> BodyModel::keep_states(const BodyModel& before, std::size_t count,
                                          std::size_t old_count) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t j = before.index_of[mode[i]];
    scratch_state[i] = j < old_count ? before.scratch_state[j] : 0.0;
  }
  return std::span(scratch_state).first(count);
}

void BodyModel::continue_in_bank(BodyModel& before) noexcept {
  release_from(before);
  before.bank.read_states(std::span(before.scratch_state).first(before.audible_modes));
  bank.write_states(keep_states(before, audible_modes, before.audible_modes));
  glide_from(before);
}

void BodyModel::continue_in_contact(BodyModel& before) noexcept {
  release_from(before);
  before.solver.read_states(before.scratch_state);
  const auto states = keep_states(before, mode.size(), before.mode.size());
  for (std::size_t i = 0; i < mode.size(); ++i)
    if (const std::size_t j = before.index_of[mode[i]]; j < before.mode.size())
      states[i] += (deflection_ratio(i, before, j) - 1.0) * before.pressed_state(j);
  solver.write_states(states);
  take_over_rigid(before);
  glide_from(before);
}

void BodyModel::take_over_rigid(const BodyModel& before) noexcept {
  solver.take_over_rigid(before.solver, before.mass_kg > 0 ? mass_kg / before.mass_kg : 1,
                         settings.size / before.settings.size);
  if (rests())
    solver.project_rigid(rigid_basis_);
}

/// Factor on an old weight with which the new state gives the old sound, so that the glide begins
/// without a step. It is limited to the factor that the change of a pressed mode requires.
Complex BodyModel::sound_ratio(std::size_t i, const BodyModel& before,
                               std::size_t j) const noexcept {
  const Complex was = before.scratch_state[j], is = scratch_state[i];
  if (was == is || math::norm(is) == 0)
    return 1;
  const double largest = std::max(1.0, 1 / math::abs(deflection_ratio(i, before, j)));
  const Complex ratio = was / is;
  return ratio * std::min(1.0, largest / math::abs(ratio));
}

void BodyModel::glide_from(BodyModel& before) noexcept {
  bank.set_clock(before.bank.clock());
  for (std::size_t l = 0; l < std::min(settings.listeners, before.settings.listeners); ++l) {
    for (const auto part : {ModeBank::kOld, ModeBank::kMiddle, ModeBank::kLatest})
      for (std::size_t i = 0; i < audible_modes; ++i) {
        const std::size_t j = before.index_of[mode[i]];
        if (j >= before.audible_modes) {
          scratch_weight_[part][i] = weight[l][i];
          continue;
        }
        scratch_weight_[part][i] = sound_ratio(i, before, j) * before.bank.weight(l, part, j);
      }
    bank.set_glide(l, before.bank.glide(l),
                   {scratch_weight_[0], scratch_weight_[1], scratch_weight_[2]});
  }
  // All listeners' glides run in step, as DirectSound requires.
  for (std::size_t l = before.settings.listeners; l < settings.listeners; ++l)
    bank.set_glide(l, before.bank.glide(0), {weight[l], weight[l], weight[l]});
  bank.set_weights(std::span(weight).first(settings.listeners));
}

/// With modal mass 1 and z = q' + alpha q + j omega q, a mode's energy is |z|^2/2 and its output is
/// Im(w z). The table's shares T are a partial isometry (ModeShare). At the sample of the exchange
///   z_now = T z_before,  w_now = T w_before,  z_left = z_before - T' z_now
/// conserve the energy, |z_now|^2 + |z_left|^2 = |z_before|^2, and the sound,
/// w_now' z_now + w_before' z_left = w_before' z_before. From then on each mode rings at its new
/// rate, w_now glides to the new table's weights, and z_left fades out.
bool BodyModel::continue_by_shares(BodyModel& before) noexcept {
  // During a contact the bank may still ring from pulses; this vibration fades out too.
  const std::size_t old_count = in_solver ? before.mode.size() : before.audible_modes;
  const auto old_states = std::span(before.scratch_state).first(old_count);
  const bool bank_ringing = before.bank.release_left() > 0 || (in_solver && before.bank.ringing());
  if (in_solver)
    before.solver.read_states(old_states);
  else
    before.bank.read_states(old_states);
  const std::size_t count = in_solver ? mode.size() : audible_modes;
  const auto states = std::span(scratch_state).first(count);
  std::fill(states.begin(), states.end(), 0.0);
  double total_energy = 0, lost_energy = 0; // twice the energies, J
  for (const Complex& z : old_states)
    total_energy += math::norm(z);
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
    lost_energy += math::norm(before.scratch_state[j]);
  if (in_solver) {
    solver.write_states(states);
    take_over_rigid(before);
  } else {
    bank.write_states(states);
  }
  glide_by_shares(before);
  if (!bank_ringing && lost_energy <= kNegligibleEnergy * total_energy) {
    before.bank.silence();
    return false;
  }
  if (in_solver)
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

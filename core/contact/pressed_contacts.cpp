#include "core/contact/pressed_contacts.hpp"

namespace tactus::contact {
namespace {

/// Calls work(row of a, row of b) for all rows of two blocks.
template <class Block, class Other, class Work>
void for_each_row(Block& a, Other& b, const Work& work) noexcept {
  using Member = PressedBlock::Row PressedBlock::*;
  using B = PressedBlock;
  for (const Member row :
       {&B::depth,         &B::approach,       &B::mean_velocity, &B::position,
        &B::velocity,      &B::external_force, &B::force,         &B::level_energy,
        &B::duration,      &B::impulse,        &B::peak,          &B::own_mobility,
        &B::mobility,      &B::mass,           &B::psi,           &B::energy_account,
        &B::gamma_scale,   &B::psi_scale,      &B::loss_scale,    &B::power_value,
        &B::power_inverse, &B::power_limit,    &B::exponent,      &B::shape,
        &B::pole_real,     &B::pole_imaginary, &B::response_real, &B::response_imaginary,
        &B::mean_real,     &B::mean_imaginary, &B::displacement,  &B::decay_over_omega,
        &B::before,        &B::step_force})
    work(a.*row, b.*row);
  for (std::size_t k = 0; k < a.power_term.size(); ++k)
    work(a.power_term[k], b.power_term[k]);
}

} // namespace

PressedContacts::PressedContacts(std::size_t exciters)
    : blocks_((exciters + PressedBlock::kLanes - 1) / PressedBlock::kLanes), at_(exciters, kNone) {
  for (PressedBlock& block : blocks_)
    for (std::size_t lane = 0; lane < PressedBlock::kLanes; ++lane)
      clear(block, lane);
}

/// Sets a lane to a contact at rest without force.
void PressedContacts::clear(PressedBlock& block, std::size_t lane) noexcept {
  static const PressedBlock none;
  for_each_row(block, none, [lane](PressedBlock::Row& to, const PressedBlock::Row& from) {
    to[lane] = from[lane];
  });
  block.depth[lane] = block.pole_real[lane] = block.power_inverse[lane] = block.position[lane] = 1;
  block.power_limit[lane] = 1;
  block.level_energy[lane] = 0;
}

void PressedContacts::add(std::size_t slot, const Exciter& e, const ModeStep& mode,
                          double sample_s) noexcept {
  const std::size_t at = count_++, l = at % PressedBlock::kLanes;
  PressedBlock& b = blocks_[at / PressedBlock::kLanes];
  at_[slot] = static_cast<std::uint32_t>(at);
  b.slot[l] = slot;
  b.used = static_cast<std::uint32_t>(l + 1);
  b.depth[l] = e.depth_m;
  b.approach[l] = e.approach_m_per_s;
  b.mean_velocity[l] = e.mean_velocity_m_per_s;
  b.position[l] = e.position_m;
  b.velocity[l] = e.velocity_m_per_s;
  b.external_force[l] = e.external_force_n;
  b.force[l] = e.force_n;
  b.step_force[l] = e.impulse_ns / sample_s;
  b.level_energy[l] = e.level_energy_j;
  b.duration[l] = e.ongoing.duration_s;
  b.impulse[l] = e.ongoing.impulse_ns;
  b.peak[l] = e.ongoing.peak_n;
  b.own_mobility[l] = 0.5 * sample_s * e.inverse_mass;
  b.mobility[l] = e.mobility[0];
  b.mass[l] = e.effective_mass_kg;
  e.impact.store_to_lane(b, l);
  b.mode[l] = mode.mode;
  b.shape[l] = mode.shape;
  b.pole_real[l] = mode.pole_real;
  b.pole_imaginary[l] = mode.pole_imaginary;
  b.response_real[l] = mode.response_real;
  b.response_imaginary[l] = mode.response_imaginary;
  b.mean_real[l] = mode.mean_real;
  b.mean_imaginary[l] = mode.mean_imaginary;
  b.displacement[l] = mode.displacement;
  b.decay_over_omega[l] = mode.decay_over_omega;
}

void PressedContacts::read(std::size_t slot, Exciter& e, double sample_s) const noexcept {
  const PressedBlock& b = block_of(slot);
  const std::size_t l = lane_of(slot);
  e.depth_m = b.depth[l];
  e.approach_m_per_s = b.approach[l];
  e.mean_velocity_m_per_s = b.mean_velocity[l];
  e.position_m = b.position[l];
  e.velocity_m_per_s = b.velocity[l];
  e.external_force_n = b.external_force[l];
  e.force_n = b.force[l];
  e.impulse_ns = sample_s * b.step_force[l];
  e.ongoing = {b.duration[l], b.impulse[l], b.peak[l]};
  e.impact.load_from_lane(b, l);
}

void PressedContacts::remove(std::size_t slot, Exciter& e, double sample_s) noexcept {
  read(slot, e, sample_s);
  PressedBlock& hole = block_of(slot);
  const std::size_t l = lane_of(slot);
  const std::size_t last = --count_, from = last % PressedBlock::kLanes;
  PressedBlock& end = blocks_[last / PressedBlock::kLanes];
  if (&hole != &end || l != from) {
    for_each_row(hole, end, [l, from](PressedBlock::Row& to, const PressedBlock::Row& row) {
      to[l] = row[from];
    });
    hole.mode[l] = end.mode[from];
    hole.slot[l] = end.slot[from];
    at_[hole.slot[l]] = at_[slot];
  }
  clear(end, from);
  end.used = static_cast<std::uint32_t>(from);
  at_[slot] = kNone;
}

} // namespace tactus::contact

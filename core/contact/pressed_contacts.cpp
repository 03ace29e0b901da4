#include "core/contact/pressed_contacts.hpp"

namespace tactus::contact {
namespace {

/// Calls work(row, row) for all rows of two blocks.
template <class Block, class Other, class Work>
void for_each_row(Block& a, Other& b, const Work& work) noexcept {
  using Member = PressedBlock::Row PressedBlock::*;
  using B = PressedBlock;
  for (const Member row :
       {&B::depth,       &B::approach,       &B::mean_velocity, &B::place,
        &B::velocity,    &B::outer_force,    &B::force,         &B::judged,
        &B::duration,    &B::impulse,        &B::highest,       &B::own,
        &B::mobility,    &B::mass,           &B::psi,           &B::bank,
        &B::gamma_scale, &B::psi_scale,      &B::loss_scale,    &B::power_value,
        &B::power_over,  &B::power_limit,    &B::exponent,      &B::shape,
        &B::turn_real,   &B::turn_imaginary, &B::response_real, &B::response_imaginary,
        &B::mean_real,   &B::mean_imaginary, &B::displacement,  &B::slowing,
        &B::before,      &B::step_force})
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

/// A lane that is not used: at rest in a contact without force.
void PressedContacts::clear(PressedBlock& block, std::size_t lane) noexcept {
  static const PressedBlock none;
  for_each_row(block, none, [lane](PressedBlock::Row& to, const PressedBlock::Row& from) {
    to[lane] = from[lane];
  });
  block.depth[lane] = block.turn_real[lane] = block.power_over[lane] = block.place[lane] = 1;
  block.power_limit[lane] = 1;
  block.judged[lane] = 0;
}

void PressedContacts::add(std::size_t slot, const Exciter& e, const Place& place,
                          double sample_s) noexcept {
  const std::size_t at = count_++, l = at % PressedBlock::kLanes;
  PressedBlock& b = blocks_[at / PressedBlock::kLanes];
  at_[slot] = static_cast<std::uint32_t>(at);
  b.slot[l] = slot;
  b.used = static_cast<std::uint32_t>(l + 1);
  b.depth[l] = e.depth_m;
  b.approach[l] = e.approach_m_per_s;
  b.mean_velocity[l] = e.mean_velocity_m_per_s;
  b.place[l] = e.place_m;
  b.velocity[l] = e.velocity_m_per_s;
  b.outer_force[l] = e.outer_force_n;
  b.force[l] = e.force_n;
  b.step_force[l] = e.impulse_ns / sample_s;
  b.judged[l] = e.judged_j;
  b.duration[l] = e.open.duration_s;
  b.impulse[l] = e.open.impulse_ns;
  b.highest[l] = e.open.highest_n;
  b.own[l] = 0.5 * sample_s * e.per_mass;
  b.mobility[l] = e.mobility[0];
  b.mass[l] = e.effective_mass_kg;
  e.impact.lend(b, l);
  b.mode[l] = place.mode;
  b.shape[l] = place.shape;
  b.turn_real[l] = place.turn_real;
  b.turn_imaginary[l] = place.turn_imaginary;
  b.response_real[l] = place.response_real;
  b.response_imaginary[l] = place.response_imaginary;
  b.mean_real[l] = place.mean_real;
  b.mean_imaginary[l] = place.mean_imaginary;
  b.displacement[l] = place.displacement;
  b.slowing[l] = place.slowing;
}

void PressedContacts::read(std::size_t slot, Exciter& e, double sample_s) const noexcept {
  const PressedBlock& b = block_of(slot);
  const std::size_t l = lane_of(slot);
  e.depth_m = b.depth[l];
  e.approach_m_per_s = b.approach[l];
  e.mean_velocity_m_per_s = b.mean_velocity[l];
  e.place_m = b.place[l];
  e.velocity_m_per_s = b.velocity[l];
  e.outer_force_n = b.outer_force[l];
  e.force_n = b.force[l];
  e.impulse_ns = sample_s * b.step_force[l];
  e.open = {b.duration[l], b.impulse[l], b.highest[l]};
  e.impact.take_back(b, l);
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

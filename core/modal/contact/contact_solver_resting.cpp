#include "core/modal/contact/contact_solver.hpp"

#include <algorithm>
#include <cmath>

/// ContactSolver: two bodies that rest on each other.
namespace tactus::modal {

void ContactSolver::begin_resting_contact(std::size_t slot, const RestingContact& rest,
                                          std::span<const double> gain,
                                          const Rigid& rigid_gain) noexcept {
  if (slot >= slots_.size())
    return;
  end(slot);
  Contact& c = contacts_[slot] = Contact{};
  c.active = c.resting = true;
  contact::Exciter& e = c.exciter;
  e.kind = contact::Exciter::Kind::kImpact;
  e.held = true;
  e.impact.set(rest.law);
  c.preload_n = contact::within(rest.preload_n, 0, contact::kMaxForce, 0);
  set_contact_gains(slot, gain, rigid_gain);
  e.position_m = e.impact.law().penetration(c.preload_n);
  e.depth_m = e.position_m - slots_[slot].surface_m;
  e.impact.hold(e.depth_m);
  e.approach_m_per_s = e.mean_velocity_m_per_s = -surface_velocity(slot);
  activate(slot);
}

/// At every contact point the constant load acts as the negative preload of that point.
void ContactSolver::update_preload_velocities() noexcept {
  for (std::size_t a = 0; a < active_count_; ++a) {
    double velocity = 0;
    for (std::size_t b = 0; b < active_count_; ++b)
      velocity += system_.coupling(a, b) * contacts_[touching_[b]].preload_n;
    slots_[touching_[a]].preload_velocity_m_per_s = -velocity;
  }
}

/// The largest number of steps in a sample for resting contacts, which last long. It is smaller for
/// many modes and contacts.
double ContactSolver::max_resting_steps() const noexcept {
  constexpr double kMaxSteps = 8;
  const double work = static_cast<double>(std::max<std::size_t>(modes_ * active_count_, 1));
  return std::clamp(static_cast<double>(kMaxWork) / work, 1.0, kMaxSteps);
}

ContactSolver::Rigid ContactSolver::project(const Rigid& motion,
                                            std::span<const Rigid> basis) noexcept {
  Rigid kept{};
  for (const Rigid& axis : basis) {
    double along = 0;
    for (std::size_t r = 0; r < kRigid; ++r)
      along += axis[r] * motion[r];
    for (std::size_t r = 0; r < kRigid; ++r)
      kept[r] += along * axis[r];
  }
  return kept;
}

void ContactSolver::project_rigid(std::span<const Rigid> basis) noexcept {
  rigid_displacement_ = project(rigid_displacement_, basis);
  rigid_velocity_ = project(rigid_velocity_, basis);
}

} // namespace tactus::modal

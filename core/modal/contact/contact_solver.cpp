#include "core/modal/contact/contact_solver.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace tactus::modal {
namespace {

using contact::ContactTerm;
using contact::Exciter;

constexpr double kStepAngle =
    0.15; // rad of the contact's oscillation in a step, which gives 27 steps in a ball's contact
constexpr double kStepRate = 176400; // 1/s, lowest rate of steps in a strike, for a force that is
                                     // exact up to 20 kHz
constexpr double kMaxHeldSteps = 4;  // a hand's contact lasts long and needs fewer steps
constexpr double kMaxFlight = 0.05;  // s after which a separated striker is given up
constexpr unsigned kMinSteps = 2;
constexpr std::uint64_t kMaxSlots = 256; // slots whose noises differ
constexpr std::size_t kMaxContactSteps =
    1024;                                  // contacts times steps in a sample, for several contacts
constexpr double kPeakToRms = 8;           // largest peak of the sum of many modes, relative to its
                                           // rms
constexpr unsigned kBoundsPeriod = 64;     // samples
constexpr double kMaxContactDurations = 8; // durations after which a striker under gravity has
                                           // settled

} // namespace

ContactSolver::ContactSolver(std::span<const Complex> rate, double sample_rate,
                             std::size_t contacts, bool rigid, std::size_t listeners,
                             VectorSet widest)
    : sample_rate_(sample_rate), has_rigid_(rigid), modes_(rate.size()), alpha_(modes_, 0),
      omega_(modes_, 1), contacts_(contacts), slots_(contacts), system_(contacts),
      touching_(contacts, 0), sampled_(contacts) {
  for (std::size_t k = 0; k < modes_; ++k) {
    alpha_[k] = -rate[k].real();
    omega_[k] = rate[k].imag();
  }
  while (max_steps_ > kMinSteps && max_steps_ * modes_ > kMaxWork)
    max_steps_ /= 2;
  contact_modes_ = ContactModes::make(rate, sample_rate, max_steps_, contacts, listeners, widest);
  steps_ = 1;
}

bool ContactSolver::choose_steps(double required) noexcept {
  // Reduces the number of steps only if a quarter of it suffices or the work is too much, because a
  // change costs as much as several steps.
  const bool too_many =
      active_count_ > 1 && steps_ * active_count_ > kMaxContactSteps && steps_ > kMinSteps;
  if (required <= steps_ && 4 * required > steps_ && !too_many)
    return false;
  unsigned steps = 1;
  while (steps < max_steps_ && steps < required)
    steps *= 2;
  if (steps == steps_)
    return false;
  set_steps(steps);
  return true;
}

void ContactSolver::set_steps(unsigned steps) noexcept {
  steps_ = steps;
  contact_modes_->set_steps(steps);
  couple();
}

void ContactSolver::couple() noexcept {
  const double h = 1 / (sample_rate_ * steps_);
  system_.clear_coupling(active_count_);
  for (std::size_t a = 0; a < active_count_; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      const std::size_t i = touching_[a], j = touching_[b];
      double mobility = contact_modes_->compliance(i, j, 0) / h; // m/(N s), mean of a step
      if (has_rigid_)
        mobility += 0.5 * h * rigid_at(slots_[i], slots_[j].rigid);
      system_.coupling(a, b) = system_.coupling(b, a) = mobility;
    }
  update_preload_velocities();
  if (active_count_ == 1 && steps_ > 1)
    next_compliance_m_per_n_ = contact_modes_->compliance(touching_[0], touching_[0], 1);
}

void ContactSolver::set_contact_gains(std::size_t slot, std::span<const double> gain,
                                      const Rigid& rigid_gain) noexcept {
  Slot& s = slots_[slot];
  Exciter& e = contacts_[slot].exciter;
  s.out_of_reach = false;
  s.bounds_age = 0;
  s.rigid = has_rigid_ ? rigid_gain : Rigid{};
  e.inverse_mass = e.kind == Exciter::Kind::kImpact && !e.held ? 1 / e.mass_kg : 0;
  e.impulse_mobility = e.inverse_mass + contact_modes_->set_gain(slot, gain);
  for (const double b : s.rigid)
    e.impulse_mobility += b * b;
  e.effective_mass_kg = e.impulse_mobility > 0 ? 1 / e.impulse_mobility : 1;
  e.level_energy_j = -1;
  s.surface_m = surface_displacement(slot);
}

/// Adds a contact, whose gains are set, to those that are solved.
void ContactSolver::activate(std::size_t slot) noexcept {
  list_touching();
  update_required_steps(slot);
  if (!choose_steps(required_steps()))
    couple();
}

ContactSolver::Contact& ContactSolver::begin_contact(std::size_t slot) noexcept {
  end(slot);
  if (active_count_ == 0)
    reset_rigid();
  Contact& contact = contacts_[slot] = Contact{};
  contact.active = true;
  return contact;
}

void ContactSolver::begin(std::size_t slot, const Strike& strike, std::span<const double> gain,
                          const Rigid& rigid_gain) noexcept {
  if (slot >= slots_.size())
    return;
  Contact& c = begin_contact(slot);
  c.fall_m_per_s2 = strike.fall_m_per_s2;
  Exciter& e = c.exciter;
  e.kind = Exciter::Kind::kImpact;
  e.impact.set(strike.law);
  e.mass_kg = strike.mass_kg;
  e.held = strike.held;
  e.velocity_m_per_s = strike.velocity_m_per_s;
  e.external_force_n = strike.fall_m_per_s2 * strike.mass_kg;
  set_contact_gains(slot, gain, rigid_gain);
  // No contact begins with work stored in it.
  const double surface = slots_[slot].surface_m;
  e.position_m = strike.held ? std::min(strike.position_m, surface) : strike.position_m + surface;
  e.depth_m = e.position_m - surface;
  e.approach_m_per_s = e.mean_velocity_m_per_s = e.velocity_m_per_s - surface_velocity(slot);
  slots_[slot].max_contact_s = kMaxFlight;
  if (!e.held && e.velocity_m_per_s > 0)
    slots_[slot].max_contact_s = std::max(
        kMaxFlight, kMaxContactDurations * strike.law.duration(e.mass_kg, e.velocity_m_per_s));
  activate(slot);
}

void ContactSolver::begin_rub(std::size_t slot, const contact::FrictionLaw& law,
                              std::span<const double> gain, const Rigid& rigid_gain,
                              std::uint64_t seed) noexcept {
  if (slot >= slots_.size())
    return;
  Exciter& e = begin_contact(slot).exciter;
  e.kind = Exciter::Kind::kFriction;
  e.friction.set(law);
  e.noise.seed(slot + 1 + kMaxSlots * (seed - 1));
  set_contact_gains(slot, gain, rigid_gain);
  e.approach_m_per_s = e.mean_velocity_m_per_s = -surface_velocity(slot);
  activate(slot);
}

void ContactSolver::take_over(std::size_t slot, const ContactSolver& before, std::size_t old_slot,
                              std::span<const double> gain, const Rigid& rigid_gain) noexcept {
  if (slot >= slots_.size() || old_slot >= before.slots_.size() ||
      !before.contacts_[old_slot].active)
    return;
  end(slot);
  Exciter& e = (contacts_[slot] = before.contacts_[old_slot]).exciter;
  set_contact_gains(slot, gain, rigid_gain);
  slots_[slot].max_contact_s = before.slots_[old_slot].max_contact_s;
  // The new shapes displace the surface, so the striker moves with it.
  e.position_m = e.depth_m + slots_[slot].surface_m;
  activate(slot);
}

void ContactSolver::take_over_rigid(const ContactSolver& before, double mass_ratio,
                                    double length_ratio) noexcept {
  for (std::size_t r = 0; r < kRigid; ++r) {
    const double scale = std::sqrt(mass_ratio) * (r < kRigid / 2 ? 1 : length_ratio);
    rigid_displacement_[r] = scale * before.rigid_displacement_[r];
    rigid_velocity_[r] = scale * before.rigid_velocity_[r];
  }
}

double ContactSolver::modal_force(std::size_t mode) const noexcept {
  double sum = 0;
  for (const std::size_t slot : std::span(touching_).first(active_count_))
    sum += contact_modes_->gain(slot, mode) *
           (contacts_[slot].resting ? slots_[slot].moments[0] : contacts_[slot].exciter.force_n);
  return sum;
}

void ContactSolver::end(std::size_t slot) noexcept {
  if (slot >= contacts_.size() || !contacts_[slot].active)
    return;
  contacts_[slot].active = false;
  contacts_[slot].exciter.force_n = 0;
  contact_modes_->remove_contact(slot);
  list_touching();
  couple();
}

void ContactSolver::list_touching() noexcept {
  active_count_ = 0;
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (contacts_[i].active)
      touching_[active_count_++] = i;
}

void ContactSolver::set_held_position(std::size_t slot, double position_m,
                                      double fastest_m_per_s) noexcept {
  if (slot >= contacts_.size() || !contacts_[slot].active)
    return;
  contacts_[slot].exciter.move_at(
      std::clamp((position_m - contacts_[slot].exciter.position_m) * sample_rate_, -fastest_m_per_s,
                 fastest_m_per_s));
}

void ContactSolver::rub(std::size_t slot, double normal_force_n, double velocity_m_per_s) noexcept {
  if (slot < contacts_.size() && contacts_[slot].active)
    contacts_[slot].exciter.rub(normal_force_n, velocity_m_per_s);
}

void ContactSolver::set_friction(std::size_t slot, const contact::FrictionLaw& law) noexcept {
  if (slot < contacts_.size() && contacts_[slot].active)
    contacts_[slot].exciter.friction.set(law);
}

void ContactSolver::move_rub(std::size_t slot, std::span<const double> gain,
                             const Rigid& rigid_gain) noexcept {
  if (slot >= contacts_.size() || !contacts_[slot].active)
    return;
  set_contact_gains(slot, gain, rigid_gain);
  activate(slot);
}

void ContactSolver::silence() noexcept {
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    end(i);
  contact_modes_->silence();
  invalidate_bounds();
  reset_rigid();
}

double ContactSolver::surface_displacement(std::size_t slot) noexcept {
  return contact_modes_->displacement(slot) + rigid_at(slots_[slot], rigid_displacement_);
}

double ContactSolver::surface_velocity(std::size_t slot) noexcept {
  return contact_modes_->velocity(slot) + rigid_at(slots_[slot], rigid_velocity_);
}

void ContactSolver::move_rigidly(double h) noexcept {
  for (std::size_t r = 0; r < kRigid; ++r)
    rigid_displacement_[r] += h * rigid_velocity_[r];
}

/// Begins a step of a contact. The rigid motions have already moved. `modal_displacement_m`: the
/// modal displacement of the point at the step's end without the step's forces.
void ContactSolver::enter_step(std::size_t position, double modal_displacement_m,
                               double h) noexcept {
  const std::size_t i = touching_[position];
  const double end = modal_displacement_m + rigid_at(slots_[i], rigid_displacement_);
  contacts_[i].exciter.enter_step(
      system_[position], (end - slots_[i].surface_m) / h + slots_[i].preload_velocity_m_per_s,
      system_.coupling(position, position), h);
}

/// Ends the step: applies its force to everything but the modes. `after`: number of steps of the
/// sample before this step.
void ContactSolver::leave_step(std::size_t position, double h, unsigned after) noexcept {
  const ContactTerm& t = system_[position];
  Contact& c = contacts_[touching_[position]];
  Slot& s = slots_[touching_[position]];
  c.exciter.leave_step(t, h);
  c.age_s += h;
  s.surface_m += h * (t.own_free_velocity - t.own_mobility * t.force - t.mean);
  const double force = net_force(position);
  if (force == 0)
    return;
  const double part = 1 / static_cast<double>(steps_);
  const double x = 1 - (2 * static_cast<double>(after) + 1) * part; // 2 v - 1 in the step's middle
  s.moments[0] += force * part;
  s.moments[1] += force * part * x;
  s.moments[2] += force * part * (1.5 * x * x - 0.5 + 0.5 * part * part);
  if (has_rigid_)
    for (std::size_t r = 0; r < kRigid; ++r) {
      rigid_displacement_[r] += s.rigid[r] * force * h * h / 2;
      rigid_velocity_[r] += s.rigid[r] * force * h;
    }
}

/// Makes one or two steps (`ahead`) of a single contact. `after`: number of steps of the sample
/// before these.
void ContactSolver::step_one_contact(std::size_t ahead, unsigned after) noexcept {
  const double h = 1 / (sample_rate_ * steps_);
  const double* const displacement =
      contact_modes_->predict_displacement(touching_[0], ahead, after + ahead == steps_);
  std::array<double, ContactModes::kMaxStepsAhead> force{};
  for (unsigned j = 0; j < ahead; ++j) {
    move_rigidly(h);
    enter_step(
        0, j == 0 ? displacement[0] : displacement[j] + next_compliance_m_per_n_ * force[j - 1], h);
    solve();
    force[j] = net_force(0);
    leave_step(0, h, after + j);
  }
  contact_modes_->apply_forces(force.data());
}

/// Makes one step of all contacts. `after`: number of steps of the sample before this step.
void ContactSolver::step_contacts(unsigned after) noexcept {
  const double h = 1 / (sample_rate_ * steps_);
  move_rigidly(h);
  for (std::size_t a = 0; a < active_count_; ++a)
    enter_step(a,
               a == 0 ? *contact_modes_->predict_displacement(touching_[0], 1, after + 1 == steps_)
                      : contact_modes_->predicted_displacement(touching_[a]),
               h);
  solve();
  for (std::size_t a = 0; a < active_count_; ++a) {
    const double force = net_force(a);
    leave_step(a, h, after);
    if (a == 0)
      contact_modes_->apply_forces(&force);
    else if (force != 0)
      contact_modes_->apply_force_at(touching_[a], force);
  }
}

/// Solves the forces of a step; those of friction in two stages.
void ContactSolver::solve() noexcept {
  system_.solve(active_count_);
  system_.find_inactive_velocities(active_count_);
  bool any_friction = false;
  for (std::size_t a = 0; a < active_count_; ++a)
    if (Exciter& e = contacts_[touching_[a]].exciter; e.kind == Exciter::Kind::kFriction) {
      e.refine(system_[a]);
      any_friction = true;
    }
  if (!any_friction)
    return;
  system_.solve(active_count_);
  system_.find_inactive_velocities(active_count_);
}

/// Updates the number of steps in a sample that a contact needs, if its energy has changed.
void ContactSolver::update_required_steps(std::size_t slot) noexcept {
  Exciter& e = contacts_[slot].exciter;
  if (e.kind == Exciter::Kind::kFriction) {
    slots_[slot].required_steps = e.rubbing_steps(1 / sample_rate_);
    return;
  }
  const double energy =
      0.5 * e.effective_mass_kg * e.approach_m_per_s * e.approach_m_per_s + e.impact.stored_j();
  if (e.level_valid(energy))
    return;
  e.level_energy_j = energy;
  const double rate = std::sqrt(e.impact.stiffest(energy, e.effective_mass_kg)) / kStepAngle;
  if (contacts_[slot].resting)
    slots_[slot].required_steps = rate / sample_rate_;
  else
    slots_[slot].required_steps = e.held ? std::min(rate / sample_rate_, kMaxHeldSteps)
                                         : std::max(rate, kStepRate) / sample_rate_;
}

double ContactSolver::required_steps() const noexcept {
  double required = 1;
  for (std::size_t a = 0; a < active_count_; ++a)
    if (const Slot& s = slots_[touching_[a]]; !s.out_of_reach)
      required = std::max(required, contacts_[touching_[a]].resting
                                        ? std::min(s.required_steps, max_resting_steps())
                                        : s.required_steps);
  double maximum = max_steps_;
  if (active_count_ > 1)
    maximum =
        std::min(maximum, static_cast<double>(std::bit_floor(kMaxContactSteps / active_count_)));
  return std::min(required, std::max(maximum, static_cast<double>(kMinSteps)));
}

double ContactSolver::step() noexcept {
  for (std::size_t a = 0; a < active_count_; ++a) {
    Exciter& e = contacts_[touching_[a]].exciter;
    e.force_n = e.impulse_ns = e.dissipated_j = 0;
    slots_[touching_[a]].moments = {};
    update_required_steps(touching_[a]);
  }
  sampled_count_ = 0;
  choose_steps(required_steps());
  if (active_count_ == 1) {
    const unsigned ahead = steps_ > 1 ? 2 : 1;
    for (unsigned s = 0; s < steps_; s += ahead)
      step_one_contact(ahead, s);
  } else if (active_count_ > 1) {
    for (unsigned s = 0; s < steps_; ++s)
      step_contacts(s);
  }
  double contact_force = 0;
  for (std::size_t a = 0; a < active_count_; ++a) {
    Exciter& e = contacts_[touching_[a]].exciter;
    e.force_n = e.impulse_ns * sample_rate_;
    const Contact& c = contacts_[touching_[a]];
    if (e.kind == Exciter::Kind::kImpact && !c.resting)
      contact_force += e.force_n;
    if (c.resting ? net_contact_force(touching_[a]) != 0 : e.force_n != 0)
      sampled_[sampled_count_++] = {touching_[a], slots_[touching_[a]].moments};
  }
  if (sampled_count_ > 0)
    invalidate_bounds();
  end_finished_contacts();
  return contact_force;
}

void ContactSolver::invalidate_bounds() noexcept {
  for (std::size_t a = 0; a < active_count_; ++a)
    slots_[touching_[a]].bounds_age = 0;
}

void ContactSolver::end_finished_contacts() noexcept {
  for (std::size_t a = active_count_; a > 0; --a) { // backwards: an ended contact leaves the list
    const std::size_t i = touching_[a - 1];
    Contact& c = contacts_[i];
    if (c.exciter.held || c.exciter.kind != Exciter::Kind::kImpact)
      continue;
    Slot& s = slots_[i];
    s.out_of_reach = false;
    if (c.exciter.depth_m > 0 || c.exciter.force_n > 0) {
      c.settled = c.fall_m_per_s2 > 0 && c.age_s > s.max_contact_s;
      if (c.settled)
        end(i);
    } else if (separates(i)) {
      end(i);
    }
  }
  // A body that is only rubbed is supported, which stops the recoil of earlier strikes.
  const auto strikes = [this](std::size_t slot) {
    return contacts_[slot].exciter.kind == Exciter::Kind::kImpact;
  };
  if (has_rigid_ && active_count_ > 0 &&
      std::none_of(touching_.begin(),
                   touching_.begin() + static_cast<std::ptrdiff_t>(active_count_), strikes))
    reset_rigid();
}

/// True if a separated striker cannot meet the surface again. Displacement and speed of a point are
/// at most the sums of all modes' amplitudes; with many modes, whose peaks never coincide, at most
/// kPeakToRms times the rms of the sum. Without forces these bounds remain valid, so they are
/// reused for kBoundsPeriod samples.
bool ContactSolver::separates(std::size_t slot) noexcept {
  const Contact& c = contacts_[slot];
  Slot& s = slots_[slot];
  if (s.bounds_age == 0)
    s.bounds = contact_modes_->motion_bounds(slot);
  s.bounds_age = (s.bounds_age + 1) % kBoundsPeriod;
  const double displacement =
      std::min(s.bounds.displacement, kPeakToRms * std::sqrt(0.5 * s.bounds.displacement_square));
  const double speed =
      std::min(s.bounds.speed, kPeakToRms * std::sqrt(0.5 * s.bounds.speed_square));
  const double separation_speed = rigid_at(s, rigid_velocity_) - c.exciter.velocity_m_per_s;
  s.out_of_reach = -c.exciter.depth_m > 2 * std::max(speed - separation_speed, 0.0) / sample_rate_;
  return separation_speed > speed || (separation_speed >= 0 && height(slot) > displacement) ||
         c.age_s > kMaxFlight;
}

void ContactSolver::apply_impulse(std::span<const float> gain, double impulse) noexcept {
  contact_modes_->apply_impulse(gain, impulse);
  invalidate_bounds();
}

double ContactSolver::energy() const noexcept {
  double sum = 0;
  for (std::size_t k = 0; k < modes_; ++k) {
    const Complex z = state(k);
    const double q = z.imag() / omega_[k];
    const double speed = z.real() - alpha_[k] * q;
    const double stiffness = omega_[k] * omega_[k] + alpha_[k] * alpha_[k];
    sum += 0.5 * (speed * speed + stiffness * q * q);
  }
  sum += rigid_energy();
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& c = contacts_[i];
    if (c.resting ? !c.active : c.age_s == 0)
      continue;
    sum += c.preload_n * slots_[i].surface_m;
    sum += c.exciter.energy();
    if (!c.exciter.held)
      sum -= c.exciter.mass_kg * c.fall_m_per_s2 * c.exciter.position_m;
  }
  return sum;
}

} // namespace tactus::modal

#pragma once

#include "core/contact/contact_system.hpp"
#include "core/contact/exciter.hpp"
#include "core/modal/contact/contact_modes.hpp"
#include "core/modal/radiation/direct_sound.hpp"

#include <array>
#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace tactus::modal {

/// A struck body and everything that touches it, in steps much shorter than a contact.
///
/// Within a step h every contact force is constant, and modes (z = q' + alpha q + j omega_d q), a
/// free body's six rigid motions and the strikers answer it exactly: z goes to
/// e^(s h) z + b F (e^(s h) - 1)/s. The forces are those of core/contact: linear in the step's mean
/// velocities (Impact, Friction), all of a step found together (ContactSystem). So what a contact
/// stores is to rounding what the bodies lose, for any step, stiffness or mode.
class ContactSolver {
public:
  static constexpr std::size_t kRigid = 6;
  /// In a sample, a power of 2; fewer for bodies of more than 16 modes, so that a sample's work is
  /// bounded: 256 for 64 modes, 4 for 4096. Fewer steps are less exact and as passive.
  static constexpr unsigned kMaxStepsPerSample = 1024;
  /// Modes times steps in a sample, so that strikes stay in time.
  static constexpr std::size_t kMaxWork = 16384;

  /// Rates s of all modes, also those too high to be heard; room for so many contacts and
  /// listeners. `rigid`: the body is free to recoil.
  ContactSolver(std::span<const std::complex<double>> rate, double sample_rate,
                std::size_t contacts, bool rigid, std::size_t listeners = 0,
                VectorSet set = best_vector_set());

  /// A striker that comes, or a hand.
  struct Strike {
    contact::ImpactLaw law{1e9, 1.5, 0};
    double mass_kg = 0.01;
    double position_m = 0;       ///< inwards, from the surface as it is; of a held striker from the
                                 ///< untouched surface
    double velocity_m_per_s = 0; ///< inwards
    double fall_m_per_s2 = 0;    ///< gravity that draws the striker towards the body
    bool held = false;           ///< its motion is given
  };
  /// A point at which two bodies of the same list of modes rest on each other: a contact along a
  /// direction in which they come apart by sum of b q, gains being those on the one less those on
  /// the other. What presses them together is constant: weight, a string, a screw.
  ///
  /// Motions are counted from the static equilibrium, in which the contact's force is `preload_n`
  /// and balances what presses. So the bodies move by the contact's force less the preload:
  /// F(x) - F0, x = x0 - sum of b q, F(x0) = F0. That is exact for any motion, also while they are
  /// apart (F = 0), because modes and rigid motions are linear.
  struct RestingContact {
    contact::ImpactLaw law{1e9, 1.5, 0};
    double preload_n = 0; ///< F0 >= 0
  };
  /// What touches at a place.
  struct Contact {
    contact::Exciter exciter;
    double fall_m_per_s2 = 0;
    double preload_n = 0; ///< of a rest
    double age_s = 0;
    bool resting = false; ///< between two bodies
    bool active = false;
    bool settled = false; ///< it has ended because the striker has come to rest
  };
  /// Starts a contact: b of all modes and of the rigid motions along it, 1/sqrt(kg).
  void begin(std::size_t slot, const Strike& strike, std::span<const double> gain,
             const std::array<double, kRigid>& rigid_gain) noexcept;
  /// A surface that rubs along the direction of the gains, until it is ended.
  void begin_rub(std::size_t slot, const contact::FrictionLaw& law, std::span<const double> gain,
                 const std::array<double, kRigid>& rigid_gain) noexcept;
  /// Two bodies touch from now on, until it is ended: wherever they are, with the force that
  /// belongs to it. Rigid motions go on as they are.
  void begin_resting_contact(std::size_t slot, const RestingContact& rest,
                             std::span<const double> gain,
                             const std::array<double, kRigid>& rigid_gain) noexcept;
  /// Force of a contact between two bodies less its preload, mean of the last sample, N.
  [[nodiscard]] double net_contact_force(std::size_t slot) const noexcept {
    return slots_[slot].moments[0];
  }
  void end(std::size_t slot) noexcept;
  /// Where a held striker shall be after the next sample; it gets there no faster than a hand.
  void set_held_position(std::size_t slot, double position_m, double fastest_m_per_s = 50) noexcept;
  /// How a surface presses and moves, until changed.
  void rub(std::size_t slot, double normal_force_n, double velocity_m_per_s) noexcept;
  void set_friction(std::size_t slot, const contact::FrictionLaw& law) noexcept;
  /// A surface that rubs slides on to another place, its bristles bent as they are.
  void move_rub(std::size_t slot, std::span<const double> gain,
                const std::array<double, kRigid>& rigid_gain) noexcept;
  /// Everything at rest, nothing touches.
  void silence() noexcept;
  [[nodiscard]] const Contact& contact(std::size_t slot) const noexcept { return contacts_[slot]; }
  [[nodiscard]] bool touching() const noexcept { return active_count_ > 0; }
  [[nodiscard]] std::size_t active() const noexcept { return active_count_; }
  /// How far the striker of a contact that has ended is above the body's resting surface, m.
  [[nodiscard]] double height(std::size_t slot) const noexcept {
    return rigid_at(slots_[slot], rigid_displacement_) - contacts_[slot].exciter.position_m;
  }
  /// Steps that one sample takes now.
  [[nodiscard]] unsigned steps() const noexcept { return steps_; }

  /// One sample on. Strikers that are gone for good become inactive. Returns the mean force of
  /// those that press, N.
  double step() noexcept;
  /// Forces of the last sample that were not zero.
  struct SampledForce {
    std::size_t slot;
    ForceMoments moments;
  };
  [[nodiscard]] std::span<const SampledForce> sampled() const noexcept {
    return std::span(sampled_).first(sampled_count_);
  }
  /// An impulse on the modes at once, N s, e.g. a sample of an outer force.
  void apply_impulse(std::span<const float> gain, double impulse) noexcept;
  /// The same on the rigid motions.
  void apply_rigid_impulse(const std::array<double, kRigid>& gain, double impulse) noexcept {
    for (std::size_t r = 0; r < kRigid; ++r)
      rigid_velocity_[r] += gain[r] * impulse;
  }
  /// Sum over modes of Im(w z).
  [[nodiscard]] double output(std::span<const std::complex<double>> weight) noexcept {
    return contact_modes_->output(weight);
  }
  /// The same with weights given before, quicker.
  void set_weight(std::size_t listener, std::span<const std::complex<double>> weight) noexcept {
    contact_modes_->set_weight(listener, weight);
  }
  void set_listening(std::size_t listeners) noexcept { contact_modes_->set_listening(listeners); }
  [[nodiscard]] double output(std::size_t listener) noexcept {
    return contact_modes_->output(listener);
  }
  /// A contact goes on with the body's new rates and shapes: same compression and striker.
  /// Both solvers' modal states must be in place; gains as in begin().
  void take_over(std::size_t slot, const ContactSolver& before, std::size_t old_slot,
                 std::span<const double> gain,
                 const std::array<double, kRigid>& rigid_gain) noexcept;
  /// A free body goes on moving where it was, its mass and lengths changed by these factors.
  void take_over_rigid(const ContactSolver& before, double mass_ratio,
                       double length_ratio) noexcept;
  /// What these orthonormal directions of the rigid motions' space hold of one.
  [[nodiscard]] static std::array<double, kRigid>
  project(const std::array<double, kRigid>& motion,
          std::span<const std::array<double, kRigid>> basis) noexcept;
  /// Leaves that of the present rigid motions.
  void project_rigid(std::span<const std::array<double, kRigid>> basis) noexcept;

  [[nodiscard]] std::complex<double> state(std::size_t mode) const noexcept {
    return contact_modes_->state(mode);
  }
  void set_state(std::size_t mode, std::complex<double> z) noexcept {
    contact_modes_->set_state(mode, z);
  }
  /// The first states, or all.
  void read_states(std::span<std::complex<double>> z) noexcept { contact_modes_->read_states(z); }
  /// The others come to rest.
  void write_states(std::span<const std::complex<double>> z) noexcept {
    contact_modes_->write_states(z);
  }
  void reset_rigid() noexcept {
    rigid_displacement_.fill(0);
    rigid_velocity_.fill(0);
  }
  [[nodiscard]] std::size_t modes() const noexcept { return modes_; }
  /// Energy of rigid motion, J.
  [[nodiscard]] double rigid_energy() const noexcept {
    double sum = 0;
    for (const double speed : rigid_velocity_)
      sum += 0.5 * speed * speed;
    return sum;
  }
  /// Energy of modes, rigid motion, strikers and contacts, J; of what presses two bodies together,
  /// its work from the equilibrium on.
  [[nodiscard]] double energy() const noexcept;

private:
  using Rigid = std::array<double, kRigid>;
  struct Slot {
    Rigid rigid{};
    double required_steps = 1; ///< in a sample, for the energy that the contact was judged by
    double max_contact_s = 0;  ///< a contact that lasts longer lies still
    bool out_of_reach = false; ///< nothing can touch within the next sample
    ContactModes::Reach reach; ///< of the modes at the place
    unsigned reach_age = 0;    ///< samples that it has been known for; 0: it is not
    double surface_m = 0;      ///< of the place, after the steps so far
    double preload_velocity_m_per_s = 0; ///< of the place, mean of a step, for all that presses
    ForceMoments moments{};              ///< of the force within the sample at hand
  };
  [[nodiscard]] static double rigid_at(const Slot& slot, const Rigid& q) noexcept {
    double sum = 0;
    for (std::size_t r = 0; r < kRigid; ++r)
      sum += slot.rigid[r] * q[r];
    return sum;
  }
  Contact& begin_contact(std::size_t slot) noexcept;
  [[nodiscard]] double net_force(std::size_t position) const noexcept {
    return system_[position].force - contacts_[touching_[position]].preload_n;
  }
  void find_preload_velocities() noexcept;
  [[nodiscard]] double max_resting_steps() const noexcept;
  void fill(std::size_t slot, std::span<const double> gain, const Rigid& rigid_gain) noexcept;
  void activate(std::size_t slot) noexcept;
  void find_required_steps(std::size_t slot) noexcept;
  [[nodiscard]] double required_steps() const noexcept;
  bool choose_steps(double required) noexcept;
  void set_steps(unsigned steps) noexcept;
  void couple() noexcept;
  void move_rigidly(double h) noexcept;
  void enter_step(std::size_t position, double modal_displacement_m, double h) noexcept;
  void leave_step(std::size_t position, double h, unsigned after) noexcept;
  void solve() noexcept;
  void step_one_contact(std::size_t ahead, unsigned after) noexcept;
  void step_contacts(unsigned after) noexcept;
  [[nodiscard]] double surface_displacement(std::size_t slot) noexcept;
  [[nodiscard]] double surface_velocity(std::size_t slot) noexcept;
  void list_touching() noexcept;
  void invalidate_reach() noexcept;
  void end_finished_contacts() noexcept;
  [[nodiscard]] bool separates(std::size_t slot) noexcept;

  double sample_rate_;
  bool has_rigid_;
  std::size_t modes_;
  std::vector<double> alpha_, omega_;
  std::unique_ptr<ContactModes> contact_modes_;
  Rigid rigid_displacement_{}, rigid_velocity_{};
  std::vector<Contact> contacts_;
  std::vector<Slot> slots_;
  contact::ContactSystem system_;      ///< by position in touching_
  double next_compliance_m_per_n_ = 0; ///< of the only contact's place, a step after its force
  std::vector<std::size_t> touching_;  ///< the active contacts, in the order of their slots
  std::size_t active_count_ = 0;
  std::vector<SampledForce> sampled_;
  std::size_t sampled_count_ = 0;
  unsigned steps_ = 0, max_steps_ = kMaxStepsPerSample;
};

} // namespace tactus::modal

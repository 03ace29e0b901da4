#pragma once

#include "core/contact/contact_system.hpp"
#include "core/contact/exciter.hpp"
#include "core/dsp/complex.hpp"
#include "core/modal/contact/contact_modes.hpp"
#include "core/modal/radiation/direct_sound.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tactus::modal {

/// Simulates the contacts of a modal body with strikers, hands, rubbing surfaces and a board, in
/// steps that are much shorter than a contact.
///
/// Within a step h every contact force is constant. Modes (z = q' + alpha q + j omega_d q), the six
/// rigid motions of a free body and the strikers move exactly under it: z goes to e^(s h) z + b F
/// (e^(s h) - 1)/s. The force laws are those of core/contact (Impact, Friction); within a step they
/// are linear in the mean velocities, and all forces of a step are solved together (ContactSystem).
/// The energy that a contact stores equals the energy that the bodies lose, apart from rounding,
/// for any step, stiffness or mode.
class ContactSolver {
public:
  static constexpr std::size_t kRigid = 6;
  /// A power of 2. Bodies with more than 16 modes have fewer steps (kMaxWork): 256 for 64 modes, 4
  /// for 4096. Fewer steps are less exact and still passive.
  static constexpr unsigned kMaxStepsPerSample = 1024;
  /// Modes times steps in a sample: bounds the computing time.
  static constexpr std::size_t kMaxWork = 16384;

  /// Allocates. `rate`: s of all modes in 1/s, also of those too high to be heard. `contacts`,
  /// `listeners`: the number of slots. `rigid`: the body is free to recoil.
  ContactSolver(std::span<const Complex> rate, double sample_rate, std::size_t contacts, bool rigid,
                std::size_t listeners = 0, VectorSet widest = simd::kWidest);

  /// A striker in flight, or a hand (held).
  struct Strike {
    contact::ImpactLaw law{1e9, 1.5, 0};
    double mass_kg = 0.01;
    double position_m = 0;       ///< inwards, from the present surface; for a held striker, from
                                 ///< the surface at rest
    double velocity_m_per_s = 0; ///< inwards
    double fall_m_per_s2 = 0;    ///< gravity towards the body
    bool held = false;           ///< its motion is given
  };
  /// A point at which two bodies, whose modes are in one list, rest on each other. The gap opens by
  /// the sum of b q, where b are the gains on one body minus the gains on the other. A constant
  /// load (weight, a string, a screw) presses the bodies together.
  ///
  /// Motions are measured from the static equilibrium, in which the contact force is the preload
  /// F0. The net force on the bodies is F(x) - F0, where x = x0 - sum of b q and F(x0) = F0. This
  /// is exact for any motion, also while the bodies are apart (F = 0), because modes and rigid
  /// motions are linear.
  struct RestingContact {
    contact::ImpactLaw law{1e9, 1.5, 0};
    double preload_n = 0; ///< F0 >= 0
  };
  /// The state of one contact.
  struct Contact {
    contact::Exciter exciter;
    double fall_m_per_s2 = 0;
    double preload_n = 0; ///< preload of a resting contact
    double age_s = 0;
    bool resting = false; ///< between two bodies
    bool active = false;
    bool settled = false; ///< it has ended because the striker has come to rest on the body
  };
  /// Begins a contact. `gain`, `rigid_gain`: b of all modes and of the rigid motions along the
  /// contact's direction, 1/sqrt(kg).
  void begin(std::size_t slot, const Strike& strike, std::span<const double> gain,
             const std::array<double, kRigid>& rigid_gain) noexcept;
  /// Begins friction along the direction of the gains; it lasts until end(). `seed`: for the noise
  /// of its roughness.
  void begin_rub(std::size_t slot, const contact::FrictionLaw& law, std::span<const double> gain,
                 const std::array<double, kRigid>& rigid_gain, std::uint64_t seed = 1) noexcept;
  /// Begins a contact between two bodies; it lasts until end(). Its force follows from the present
  /// positions of the bodies. Rigid motions continue.
  void begin_resting_contact(std::size_t slot, const RestingContact& rest,
                             std::span<const double> gain,
                             const std::array<double, kRigid>& rigid_gain) noexcept;
  /// Force of a resting contact minus its preload, N: the mean over the last sample.
  [[nodiscard]] double net_contact_force(std::size_t slot) const noexcept {
    return slots_[slot].moments[0];
  }
  /// The sum over the contacts of b times the mean force of the last sample, N/sqrt(kg).
  [[nodiscard]] double modal_force(std::size_t mode) const noexcept;
  void end(std::size_t slot) noexcept;
  /// Target of a held striker for the end of the next sample; its speed is limited.
  void set_held_position(std::size_t slot, double position_m, double fastest_m_per_s = 50) noexcept;
  /// Normal force and velocity of a rubbing surface, which stay until they are changed.
  void rub(std::size_t slot, double normal_force_n, double velocity_m_per_s) noexcept;
  void set_friction(std::size_t slot, const contact::FrictionLaw& law) noexcept;
  /// Moves a rubbing surface to another point; its bristle deflection is kept.
  void move_rub(std::size_t slot, std::span<const double> gain,
                const std::array<double, kRigid>& rigid_gain) noexcept;
  /// Ends all contacts and sets all motion to zero.
  void silence() noexcept;
  [[nodiscard]] const Contact& contact(std::size_t slot) const noexcept { return contacts_[slot]; }
  [[nodiscard]] bool touching() const noexcept { return active_count_ > 0; }
  [[nodiscard]] std::size_t active() const noexcept { return active_count_; }
  /// Height of the striker of an ended contact above the body's surface at rest, m.
  [[nodiscard]] double height(std::size_t slot) const noexcept {
    return rigid_at(slots_[slot], rigid_displacement_) - contacts_[slot].exciter.position_m;
  }
  /// Steps in a sample at present.
  [[nodiscard]] unsigned steps() const noexcept { return steps_; }

  /// Advances by one sample. Strikers that cannot meet the body again become inactive. Returns the
  /// sum of the mean forces of strikers and hands, N.
  double step() noexcept;
  /// A force of the last sample that was not zero.
  struct SampledForce {
    std::size_t slot;
    ForceMoments moments;
  };
  [[nodiscard]] std::span<const SampledForce> sampled() const noexcept {
    return std::span(sampled_).first(sampled_count_);
  }
  /// An impulse on the modes at once, N s, e.g. of one sample of an external force.
  void apply_impulse(std::span<const float> gain, double impulse) noexcept;
  /// An impulse on the rigid motions at once, N s.
  void apply_rigid_impulse(const std::array<double, kRigid>& gain, double impulse) noexcept {
    for (std::size_t r = 0; r < kRigid; ++r)
      rigid_velocity_[r] += gain[r] * impulse;
  }
  /// The sum over the modes of Im(w z).
  [[nodiscard]] double output(std::span<const Complex> weight) noexcept {
    return contact_modes_->output(weight);
  }
  /// The sum over the modes of Im(w z) with weights that are set beforehand; faster.
  void set_weight(std::size_t listener, std::span<const Complex> weight) noexcept {
    contact_modes_->set_weight(listener, weight);
  }
  void set_listening(std::size_t listeners) noexcept { contact_modes_->set_listening(listeners); }
  [[nodiscard]] double output(std::size_t listener) noexcept {
    return contact_modes_->output(listener);
  }
  /// Continues a contact of another solver, whose body had different rates and shapes, with the
  /// same compression and striker. Both solvers' modal states must be set; gains as in begin().
  void take_over(std::size_t slot, const ContactSolver& before, std::size_t old_slot,
                 std::span<const double> gain,
                 const std::array<double, kRigid>& rigid_gain) noexcept;
  /// Continues the rigid motions of another solver, whose body had a different mass and different
  /// lengths.
  void take_over_rigid(const ContactSolver& before, double mass_ratio,
                       double length_ratio) noexcept;
  /// The orthogonal projection of a rigid motion onto the span of an orthonormal basis.
  [[nodiscard]] static std::array<double, kRigid>
  project(const std::array<double, kRigid>& motion,
          std::span<const std::array<double, kRigid>> basis) noexcept;
  /// Projects the present rigid motions.
  void project_rigid(std::span<const std::array<double, kRigid>> basis) noexcept;

  [[nodiscard]] Complex state(std::size_t mode) const noexcept {
    return contact_modes_->state(mode);
  }
  void set_state(std::size_t mode, Complex z) noexcept { contact_modes_->set_state(mode, z); }
  /// Reads all states, or the first ones.
  void read_states(std::span<Complex> z) noexcept { contact_modes_->read_states(z); }
  /// Writes all states, or the first ones; the others become zero.
  void write_states(std::span<const Complex> z) noexcept { contact_modes_->write_states(z); }
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
  /// Energy of modes, rigid motions, strikers and contacts, J; for a preload, its work since the
  /// equilibrium.
  [[nodiscard]] double energy() const noexcept;

private:
  using Rigid = std::array<double, kRigid>;
  struct Slot {
    Rigid rigid{};
    double required_steps = 1; ///< steps in a sample, for the contact's present energy
    double max_contact_s = 0;  ///< a falling striker's contact that lasts longer has settled
    bool out_of_reach = false; ///< the surface cannot meet the striker within the next sample
    ContactModes::MotionBounds bounds; ///< bounds of the modes at the point
    unsigned bounds_age = 0;           ///< samples since `bounds` was computed; 0: it is not valid
    double surface_m = 0;              ///< displacement of the point after the steps so far
    double preload_velocity_m_per_s = 0; ///< mean velocity of the point in a step, by all preloads
    ForceMoments moments{};              ///< moments of the force within the present sample
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
  void update_preload_velocities() noexcept;
  [[nodiscard]] double max_resting_steps() const noexcept;
  void set_contact_gains(std::size_t slot, std::span<const double> gain,
                         const Rigid& rigid_gain) noexcept;
  void activate(std::size_t slot) noexcept;
  void update_required_steps(std::size_t slot) noexcept;
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
  void invalidate_bounds() noexcept;
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
  contact::ContactSystem system_;      ///< system by position in touching_
  double next_compliance_m_per_n_ = 0; ///< compliance of a single contact, a step after its force
  std::vector<std::size_t> touching_;  ///< the active contacts, in the order of their slots
  std::size_t active_count_ = 0;
  std::vector<SampledForce> sampled_;
  std::size_t sampled_count_ = 0;
  unsigned steps_ = 0, max_steps_ = kMaxStepsPerSample;
};

} // namespace tactus::modal

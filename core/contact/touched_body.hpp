#pragma once

#include "core/contact/body_kernel.hpp"
#include "core/contact/contact_system.hpp"
#include "core/contact/exciter.hpp"
#include "core/contact/modal_body.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::contact {

/// A vibrating body that any number of masses strike and surfaces rub at once, at places of its own
/// each; heard at others.
///
/// All contacts of a step are solved together (ContactSystem). Friction's second stage solves once
/// more with the coefficients that the first led to. The system has one unknown a contact, or one a
/// mode if there are fewer modes than contacts. Sums run over the contacts in an order that follows
/// from what the contacts are, not from their numbers: contacts that change places give the same
/// bits.
///
/// Steps are a sample or a power of two finer, to 1/64, as the stiffest contact that is near needs.
/// A contact too short even for these gives an impulse with the restitution of its law; impulses of
/// one moment are found together as well, and never add energy.
class TouchedBody {
public:
  /// Allocates for so many modes, exciters (slots 0...) and places to listen at.
  explicit TouchedBody(std::size_t max_modes, std::size_t exciters = 1, std::size_t ears = 1);

  /// May be called again at any time: the body goes on sounding.
  void prepare(double sample_rate) noexcept;

  /// Same energy in each mode, whatever the new numbers are; what touches stays in touch.
  void set_modes(std::span<const Mode> modes) noexcept;
  /// Shape of the modes at an exciter's place, and where it is heard: displacement there for a
  /// modal displacement of 1. Missing numbers are 0. Initially all 1.
  void set_place(std::size_t exciter, std::span<const double> shape) noexcept;
  void set_ear(std::size_t ear, std::span<const double> shape) noexcept;

  /// The slot holds a mass that flies freely, nothing, or a surface that rubs. Changing the law of
  /// a contact under way adds no energy.
  void set_impact(std::size_t exciter, const ImpactLaw& law, double mass_kg) noexcept;
  /// A striker whose motion is given (throw_mass() for where it begins, lead()). At rest, on a
  /// place with shapes of the modes of two bodies, both counted into their surfaces, it is the
  /// contact between the two: all bodies' modes then stand in one list.
  void set_held(std::size_t exciter, const ImpactLaw& law) noexcept;
  void set_friction(std::size_t exciter, const FrictionLaw& law) noexcept;
  void clear(std::size_t exciter) noexcept;

  /// Puts an impact's mass so far above the surface, with a velocity into the body.
  void throw_mass(std::size_t exciter, double gap_m, double velocity_m_per_s) noexcept;
  /// Velocity of a held striker, into the body, until changed.
  void lead(std::size_t exciter, double velocity_m_per_s) noexcept;
  /// Outer force on an impact's mass, into the body, until changed.
  void push_mass(std::size_t exciter, double force_n) noexcept;
  /// How a friction's surface presses and moves, until changed.
  void rub(std::size_t exciter, double normal_force_n, double velocity_m_per_s) noexcept;
  /// Of friction's noise.
  void seed(std::size_t exciter, std::uint64_t seed) noexcept;
  /// A force on the body itself at the slot's place, during the next sample only.
  void push_body(std::size_t exciter, double force_n) noexcept;
  /// An impulse on the body at the slot's place, at once, N s.
  void knock_body(std::size_t exciter, double impulse_ns) noexcept;
  /// Sets one mode's velocity at once, m/s for a shape of 1: how bodies are set off.
  void set_modal_velocity(std::size_t mode, double velocity_m_per_s) noexcept;
  /// Steps of a sample, at least: 1, 2, 4 ... 64.
  void set_least_steps(unsigned steps) noexcept;

  /// One sample on.
  void step() noexcept;
  /// As many samples as the spans hold: for each push_mass() or rub(), step(), hear() and force(),
  /// with the same result, at less cost where the exciter is the only one.
  void run_mass(std::size_t exciter, std::span<const double> force_n, std::span<double> heard,
                std::span<double> contact_n) noexcept;
  void run_rub(std::size_t exciter, std::span<const double> velocity_m_per_s,
               std::span<const double> normal_force_n, std::span<double> heard,
               std::span<double> friction_n) noexcept;
  /// Surface velocity at an ear, m/s.
  [[nodiscard]] double hear(std::size_t ear = 0) const noexcept;
  /// The exciter's mean force on the body in the last sample, N.
  [[nodiscard]] double force(std::size_t exciter) const noexcept {
    return exciters_[exciter].force_n;
  }
  [[nodiscard]] const Exciter& exciter(std::size_t slot) const noexcept { return exciters_[slot]; }
  [[nodiscard]] std::size_t exciters() const noexcept { return exciters_.size(); }
  [[nodiscard]] const ModalBody& body() const noexcept { return body_; }
  /// Steps that the last sample took.
  [[nodiscard]] unsigned steps() const noexcept { return 1U << level_; }
  /// Of modes, masses and contacts, J. Without outer forces it never grows.
  [[nodiscard]] double energy() const noexcept;
  /// True while modes ring or something is near.
  [[nodiscard]] bool active() const noexcept { return sounds_ || near_ > 0; }
  /// Instructions that every processor has, for comparison.
  void use_baseline() noexcept {
    kernel_ = &baseline_body_kernel();
    system_.use_baseline();
  }
  /// All at rest, masses 1 m away.
  void reset() noexcept;

private:
  void work_out_steps() noexcept;
  void measure_places() noexcept;
  void keep_places() noexcept;
  void work_out_place(std::size_t exciter) noexcept;
  void become_impact(std::size_t exciter, const ImpactLaw& law, bool held) noexcept;
  void sort() noexcept;
  void look_for_difference() noexcept;
  [[nodiscard]] bool goes_before(std::size_t a, std::size_t b) const noexcept;
  [[nodiscard]] double surface(std::size_t exciter) const noexcept;
  [[nodiscard]] double surface_velocity(std::size_t exciter) const noexcept;
  void look_around() noexcept;
  void judge(Exciter& e) const noexcept;
  void fly(Exciter& e) const noexcept;
  void change_level(std::size_t level) noexcept;
  void work_out_ear(std::size_t ear) noexcept;
  void touch_many() noexcept;
  void knock_many() noexcept;
  void solve() noexcept;
  void couple() noexcept;
  void touch_one() noexcept;
  void run(std::size_t exciter, const Stretch& whole) noexcept;
  std::size_t rest(std::size_t exciter, const Stretch& whole) noexcept;
  [[nodiscard]] bool steady(std::size_t exciter) const noexcept;
  [[nodiscard]] PlaceView place_view(std::size_t exciter) const noexcept;
  void look_back() noexcept;
  void focus(std::size_t exciter) noexcept;
  void solve_by_mode(std::span<const std::size_t> acting) noexcept;
  [[nodiscard]] ModesView view(std::size_t level) noexcept;
  [[nodiscard]] double step_length() const noexcept { return step_s_[level_]; }

  ModalBody body_;
  const BodyKernel* kernel_;
  std::vector<Exciter> exciters_;
  std::vector<std::vector<double>> shape_, ear_shape_;
  std::vector<ModeArray> place_;                    ///< shapes over sqrt(m)
  std::vector<ModeArray> ear_real_, ear_imaginary_; ///< velocity there = these times the state
  ModeArray outer_, mean_; ///< forces over sqrt(m) from outside; modes' mean velocities
  ModeArray push_real_, push_imaginary_, ahead_real_,
      ahead_imaginary_; ///< of the one exciter that is near (PlaceView)
  double answer_ = 0;
  Foresight foresight_;
  bool foreseen_ = false; ///< foresight_ is of the state as it is
  bool has_outer_ = false, sounds_ = false, unsorted_ = true, tied_ = false, moved_ = false;
  bool coupled_ = false; ///< the system's coupling or the PlaceView are those of close_
  std::array<double, kLevels> step_s_{}; ///< length of a step, by level
  std::size_t level_ = 0, least_level_ = 0, quiet_ = 0, near_ = 0;
  std::uint64_t clock_ = 0;
  std::vector<std::size_t> order_, close_; ///< slots: all in use; those near
  std::vector<char> like_the_one_before_;  ///< by position in order_: the same but for its drive
  ContactSystem system_;                   ///< of one step, by position in close_
  std::vector<Push> pushes_;
  ModeArray matrix_, right_, other_; ///< of solve_by_mode()
};

} // namespace tactus::contact

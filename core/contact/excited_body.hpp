#pragma once

#include "core/contact/body_kernel.hpp"
#include "core/contact/contact_islands.hpp"
#include "core/contact/contact_system.hpp"
#include "core/contact/exciter.hpp"
#include "core/contact/modal_body.hpp"
#include "core/contact/pressed_contacts.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::contact {

/// A vibrating body that any number of masses strike and surfaces rub at once, at places of its own
/// each; heard at others.
///
/// The contacts that are near are divided into islands, which share no mode (Islands): separate
/// bodies in one list of modes, or bodies that do not touch each other at the moment. Each island
/// has a solution and steps of its own; modes that no contact moves ring once a sample.
///
/// All contacts of an island's step are solved together (ContactSystem). Friction's second stage
/// solves once more with the coefficients that the first led to. The system has one unknown a
/// contact, or one a mode if there are fewer modes than contacts. Sums run over the contacts in an
/// order that follows from what the contacts are, not from their numbers: contacts that change
/// places give the same bits.
///
/// Steps are a sample or a power of two finer, to 1/64, as the stiffest contact of the island
/// needs. A contact too short even for these gives an impulse with the restitution of its law;
/// impulses of one moment are found together as well, and never add energy.
class ExcitedBody {
public:
  /// Allocates for so many modes, exciters (slots 0...) and places to listen at.
  explicit ExcitedBody(std::size_t max_modes, std::size_t exciters = 1, std::size_t pickups = 1);

  /// May be called again at any time: the body goes on sounding.
  void prepare(double sample_rate) noexcept;

  /// Same energy in each mode, whatever the new numbers are; what touches stays in touch.
  void set_modes(std::span<const Mode> modes) noexcept;
  /// Shape of the modes at an exciter's place, and where it is heard: displacement there for a
  /// modal displacement of 1. Missing numbers are 0. Initially all 1.
  void set_contact_shape(std::size_t exciter, std::span<const double> shape) noexcept;
  void set_pickup(std::size_t pickup, std::span<const double> shape) noexcept;

  /// The slot holds a mass that flies freely, nothing, or a surface that rubs. Changing the law of
  /// a contact under way adds no energy.
  void set_impact(std::size_t exciter, const ImpactLaw& law, double mass_kg) noexcept;
  /// A striker whose motion is given (launch_mass() for where it begins, lead()). At rest, on a
  /// place with shapes of the modes of two bodies, both counted into their surfaces, it is the
  /// contact between the two: all bodies' modes then stand in one list.
  void set_held(std::size_t exciter, const ImpactLaw& law) noexcept;
  void set_friction(std::size_t exciter, const FrictionLaw& law) noexcept;
  void clear(std::size_t exciter) noexcept;

  /// Puts an impact's mass so far above the surface, with a velocity into the body.
  void launch_mass(std::size_t exciter, double gap_m, double velocity_m_per_s) noexcept;
  /// Velocity of a held striker, into the body, until changed.
  void set_held_velocity(std::size_t exciter, double velocity_m_per_s) noexcept;
  /// Outer force on an impact's mass, into the body, until changed.
  void set_mass_force(std::size_t exciter, double force_n) noexcept;
  /// How a friction's surface presses and moves, until changed.
  void rub(std::size_t exciter, double normal_force_n, double velocity_m_per_s) noexcept;
  /// Of friction's noise.
  void seed(std::size_t exciter, std::uint64_t seed) noexcept;
  /// A force on the body itself at the slot's place, during the next sample only.
  void apply_force(std::size_t exciter, double force_n) noexcept;
  /// An impulse on the body at the slot's place, at once, N s.
  void apply_impulse(std::size_t exciter, double impulse_ns) noexcept;
  /// Sets one mode's velocity at once, m/s for a shape of 1: how bodies are set off.
  void set_modal_velocity(std::size_t mode, double velocity_m_per_s) noexcept;
  /// Steps of a sample, at least: 1, 2, 4 ... 64.
  void set_min_steps(unsigned steps) noexcept;

  /// One sample on.
  void step() noexcept;
  /// As many samples as the spans hold: for each set_mass_force() or rub(), step(), hear() and
  /// force(), with the same result, at less cost where the exciter is the only one.
  void run_mass(std::size_t exciter, std::span<const double> force_n, std::span<double> output,
                std::span<double> contact_n) noexcept;
  void run_rub(std::size_t exciter, std::span<const double> velocity_m_per_s,
               std::span<const double> normal_force_n, std::span<double> output,
               std::span<double> friction_n) noexcept;
  /// Surface velocity at an ear, m/s.
  [[nodiscard]] double pickup_velocity(std::size_t pickup = 0) const noexcept;
  /// The exciter's mean force on the body in the last sample, N.
  [[nodiscard]] double force(std::size_t exciter) const noexcept {
    return pressed_.holds(exciter) ? pressed_.force(exciter) : exciters_[exciter].force_n;
  }
  [[nodiscard]] const Exciter& exciter(std::size_t slot) const noexcept {
    if (sleep_[slot].sleeps)
      catch_up(slot);
    else if (pressed_.holds(slot))
      pressed_.read(slot, exciters_[slot], step_s_[0]);
    return exciters_[slot];
  }
  [[nodiscard]] std::size_t exciters() const noexcept { return exciters_.size(); }
  [[nodiscard]] const ModalBody& body() const noexcept { return body_; }
  /// Steps that the last sample took; of several islands, the most.
  [[nodiscard]] unsigned steps() const noexcept { return 1U << level_; }
  /// Of modes, masses and contacts, J. Without outer forces it never grows.
  [[nodiscard]] double energy() const noexcept;
  /// True while modes ring or something is near.
  [[nodiscard]] bool active() const noexcept { return ringing_ || near_ > 0 || any_single_near(); }
  /// Instructions that every processor has, for comparison.
  void use_baseline() noexcept {
    kernel_ = &baseline_body_kernel();
    system_.use_baseline();
  }
  /// All at rest, masses 1 m away.
  void reset() noexcept;

private:
  static constexpr std::size_t kMaxWork = std::size_t{1} << 17; ///< products in a sample
  static constexpr std::uint64_t kFlushPeriod = 64;             ///< samples
  void compute_step_lengths() noexcept;
  void store_depth(std::size_t exciter) noexcept;
  void store_depths() noexcept;
  void restore_depths() noexcept;
  void compute_point(std::size_t exciter) noexcept;
  void make_impact(std::size_t exciter, const ImpactLaw& law, bool held) noexcept;
  void sort() noexcept;
  void check_symmetry() noexcept;
  [[nodiscard]] bool precedes(std::size_t a, std::size_t b) const noexcept;
  [[nodiscard]] double surface(std::size_t exciter) const noexcept;
  [[nodiscard]] double surface_velocity(std::size_t exciter) const noexcept;
  void update_proximity() noexcept;
  [[nodiscard, gnu::always_inline]] inline bool update_proximity_of(std::size_t exciter,
                                                                    bool measure) noexcept;
  void choose_level() noexcept;
  void update_single_contacts(bool measure) noexcept;
  void find_level(Exciter& e) const noexcept;
  void find_friction_level(Exciter& e) const noexcept;
  void advance_free_mass(Exciter& e) const noexcept;
  void change_level(std::size_t level) noexcept;
  void compute_pickup(std::size_t pickup) noexcept;
  /// What one solution needs: contacts, the modes that they move (all arrays from the same mode on)
  /// and the length of the steps.
  struct Group {
    std::span<const std::size_t> slots;
    ModesView modes;
    std::size_t mode_count;
    const double* external; ///< forces from outside, null: none
    std::size_t level;
  };
  void step_coupled(const Group& group) noexcept;
  void solve_impulses(const Group& group) noexcept;
  void solve(const Group& group) noexcept;
  void solve_by_mode(const Group& group, std::span<const std::size_t> acting) noexcept;
  void couple(const Group& group) noexcept;
  void step_in_place() noexcept;
  void ring(std::size_t first, std::size_t end) noexcept;
  void step_free() noexcept;
  /// True where update_proximity() would find what it found before: everything sleeps.
  [[nodiscard]] bool all_sleep() const noexcept {
    return near_ == 0 && order_.empty() && single_awake_.empty() && !any_single_near() &&
           !awake_changed_ && range_known_ && one_range_ && level_ == min_level_;
  }

  // Several islands (touched_islands.cpp).
  void find_islands_in_use() noexcept;
  void divide() noexcept;
  void find_range() noexcept;
  void assign_packed_ranges() noexcept;
  void step_islands() noexcept;
  void step_single(std::size_t exciter, std::size_t level) noexcept;
  [[nodiscard]] bool step_single_impact(std::size_t exciter) noexcept;
  [[nodiscard]] bool any_single_near() const noexcept {
    return !single_near_.empty() || !pressed_.empty();
  }
  void update_pressed(bool measure) noexcept;
  void step_pressed() noexcept;
  void gather_pressed() noexcept;
  void release_pressed(std::size_t exciter) noexcept;
  [[nodiscard]] Group pack(std::size_t island, std::size_t level, bool in_body) noexcept;
  [[nodiscard]] bool few(std::size_t island) const noexcept;
  [[nodiscard]] std::size_t island_level(std::size_t island) const noexcept;
  [[nodiscard]] std::size_t island_work(std::size_t island) const noexcept;
  [[nodiscard]] std::size_t affordable_level(std::size_t work, std::size_t level) const noexcept;
  void distribute_work() noexcept;

  // Exciters that stay away (touched_sleep.cpp).
  void list_awake() noexcept;
  void update_sleep() noexcept;
  [[nodiscard]] bool cannot_reach(std::size_t exciter, double samples) const noexcept;
  void catch_up(std::size_t exciter) const noexcept;
  void wake(std::size_t exciter) noexcept {
    if (sleep_[exciter].sleeps)
      wake_island(exciter);
    else if (pressed_.holds(exciter))
      release_pressed(exciter);
  }
  void wake_island(std::size_t exciter) noexcept;
  void wake_around(std::size_t exciter) noexcept;
  void wake_all() noexcept;
  void run(std::size_t exciter, const SampleBatch& batch) noexcept;
  std::size_t skip_idle(std::size_t exciter, const SampleBatch& batch) noexcept;
  [[nodiscard]] bool can_batch(std::size_t exciter) const noexcept;
  void check_state() noexcept;
  /// The modes have changed otherwise than by the steps.
  void invalidate_prediction() noexcept { predicted_ = islands_predicted_ = output_known_ = false; }
  void prepare_single_contact(std::size_t exciter) noexcept;
  struct PointArrays;
  [[nodiscard]] static PointView make_point_view(const ModesView& modes, const double* shape,
                                                 const PointArrays& into) noexcept;
  void step_only_contact(std::size_t exciter, const ModesView& modes, const PointView& point,
                         Prediction& prediction, bool& predicted, std::size_t level) noexcept;
  [[nodiscard]] ModesView view(std::size_t level, std::size_t first, std::size_t end) noexcept;
  [[nodiscard]] ModesView view() noexcept { return view(level_, range_first_, range_end_); }
  [[nodiscard]] double step_length() const noexcept { return step_s_[level_]; }
  /// Products that a step's solution of so many contacts on so many modes takes.
  [[nodiscard]] static std::size_t work(std::size_t contacts, std::size_t modes) noexcept {
    const std::size_t small = std::min(contacts, modes), big = std::max(contacts, modes);
    return small * small * (big + small) / 2 + 4 * small * big;
  }

  ModalBody body_;
  const BodyKernel* kernel_;
  /// Mutable: where a mass that sleeps has flown to, and what a contact in pressed_ is, are found
  /// when they are asked for.
  mutable std::vector<Exciter> exciters_;
  std::vector<std::vector<double>> shape_, pickup_shape_;
  std::vector<ModeArray> point_shape_; ///< shapes over sqrt(m)
  std::vector<ModeArray> pickup_real_,
      pickup_imaginary_;      ///< velocity there = these times the state
  ModeArray external_, mean_; ///< forces over sqrt(m) from outside; modes' mean velocities
  /// What a PointView points to.
  struct PointArrays {
    double *response_at_point_real, *response_at_point_imaginary, *next_mean_real,
        *next_mean_imaginary;
  };
  struct PointMemory {
    ModeArray response_at_point_real, response_at_point_imaginary, next_mean_real,
        next_mean_imaginary;
    explicit PointMemory(std::size_t modes)
        : response_at_point_real(modes), response_at_point_imaginary(modes), next_mean_real(modes),
          next_mean_imaginary(modes) {}
    [[nodiscard]] PointArrays from(std::size_t mode) noexcept {
      return {response_at_point_real.data() + mode, response_at_point_imaginary.data() + mode,
              next_mean_real.data() + mode, next_mean_imaginary.data() + mode};
    }
  };
  PointMemory point_memory_; ///< of the one exciter that is near
  PointView point_view_{};
  Prediction prediction_;
  bool predicted_ = false;    ///< prediction_ is of the state as it is
  ModesView all_modes_{};     ///< all modes in steps of a sample
  double output_m_per_s_ = 0; ///< at the first ear, if output_known_
  bool output_known_ = false;
  bool has_external_force_ = false, ringing_ = false, order_stale_ = true, has_identical_ = false,
       drives_changed_ = false;
  bool coupled_ = false; ///< the system's coupling or point_view_ are those of near_slots_
  std::array<double, kLevels> step_s_{}; ///< length of a step, by level
  std::size_t level_ = 0, min_level_ = 0, coarse_count_ = 0, near_ = 0;
  std::uint64_t clock_ = 0;
  /// Slots: in use and awake but for the lone ones; those of them that are near.
  std::vector<std::size_t> order_, near_slots_;
  std::vector<char> same_as_previous_; ///< by position in order_: the same but for its drive
  ContactSystem system_;               ///< of one step, by position in near_slots_
  std::vector<PointForce> forces_;
  ModeArray matrix_, right_, other_;  ///< of solve_by_mode()
  std::vector<const double*> shapes_; ///< of a Group's contacts

  PointModes point_modes_;
  static constexpr std::size_t kFewModes = 4; ///< of a contact that is solved without vectors
  /// A place's modes where they are no more than that: by slot, side by side in memory.
  struct alignas(64) FewModes {
    std::uint32_t count = 0;
    std::array<std::uint32_t, kFewModes> mode{};
    std::array<double, kFewModes> shape{};
  };
  Islands in_use_;             ///< of all exciters in use: what may ever touch what
  Islands islands_;            ///< of those near, but for the lone ones
  bool islands_valid_ = false; ///< islands_ is of near_slots_
  bool range_known_ = false;   ///< and so are these: one island, and its modes, whole lanes
  bool one_range_ = true;
  std::size_t range_first_ = 0, range_end_ = 0;
  bool single_range_ = true;     ///< that is all
  std::size_t active_modes_ = 0; ///< modes that are not left out
  std::size_t used_ = 0;         ///< exciters in use
  /// Exciters that no other shares a mode with and that move few: in use; of these, those that are
  /// awake and not in pressed_; of these, those that are near.
  std::vector<std::size_t> single_, single_awake_, single_near_;
  PressedContacts pressed_;         ///< lone contacts on one mode that go on quietly
  std::vector<std::size_t> sorted_; ///< in use but for the lone ones
  std::array<std::size_t, kLevels>
      single_at_level_{};        ///< how many are near, by the level they need
  std::size_t share_ = kMaxWork; ///< products that an island's fine steps may take
  /// An island's modes in a row, with its contacts' shapes; parts of arrays, whole lanes.
  struct Packed {
    std::size_t at = 0, skip = 0, lanes = 0, shapes_at = 0, level = 0; ///< skip: lanes of others
    ContactSystem::Block block{};
    bool ready = false, in_body = false;
    PointView point{}; ///< of an only contact
    Prediction prediction{};
    bool predicted = false;
  };
  std::vector<Packed> packed_;
  ModeArray before_real_, before_imaginary_; ///< state before the sample, where all modes ring
  const double *from_real_ = nullptr, *from_imaginary_ = nullptr; ///< from where islands go on
  PointMemory packed_points_;
  bool islands_predicted_ = false; ///< the islands' foresights are of the state as it is
  ModalBody::Level packed_level_;
  ModeArray packed_real_, packed_imaginary_, packed_decay_over_omega_, packed_external_,
      packed_shapes_;

  std::vector<FewModes> few_;
  /// By exciter: asleep since when, and from where its mass flies freely.
  struct Sleep {
    bool sleeps = false;
    std::uint64_t since = 0;
    double position_m = 0, velocity_m_per_s = 0;
  };
  std::vector<Sleep> sleep_;
  std::vector<std::size_t> island_of_;     ///< by exciter: its island in in_use_
  std::vector<std::uint64_t> sleep_until_; ///< by island in in_use_: asleep until then; 0: awake
  bool awake_changed_ = false;
};

} // namespace tactus::contact

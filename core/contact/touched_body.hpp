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
  [[nodiscard]] bool active() const noexcept { return sounds_ || near_ > 0 || lone_touch(); }
  /// Instructions that every processor has, for comparison.
  void use_baseline() noexcept {
    kernel_ = &baseline_body_kernel();
    system_.use_baseline();
  }
  /// All at rest, masses 1 m away.
  void reset() noexcept;

private:
  static constexpr std::size_t kMaxWork = std::size_t{1} << 17; ///< products in a sample
  static constexpr std::uint64_t kTidyEvery = 64;               ///< samples
  void work_out_steps() noexcept;
  void measure_place(std::size_t exciter) noexcept;
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
  [[nodiscard, gnu::always_inline]] inline bool look_at(std::size_t exciter, bool look) noexcept;
  void choose_level() noexcept;
  void look_at_lone(bool look) noexcept;
  void judge(Exciter& e) const noexcept;
  void judge_rub(Exciter& e) const noexcept;
  void fly(Exciter& e) const noexcept;
  void change_level(std::size_t level) noexcept;
  void work_out_ear(std::size_t ear) noexcept;
  /// What one solution needs: contacts, the modes that they move (all arrays from the same mode on)
  /// and the length of the steps.
  struct Group {
    std::span<const std::size_t> slots;
    ModesView modes;
    std::size_t mode_count;
    const double* outer; ///< forces from outside, null: none
    std::size_t level;
  };
  void touch_many(const Group& group) noexcept;
  void knock_many(const Group& group) noexcept;
  void solve(const Group& group) noexcept;
  void solve_by_mode(const Group& group, std::span<const std::size_t> acting) noexcept;
  void couple(const Group& group) noexcept;
  void touch_in_place() noexcept;
  void ring(std::size_t first, std::size_t end) noexcept;
  void ring_alone() noexcept;
  /// True where look_around() would find what it found before: everything sleeps.
  [[nodiscard]] bool all_sleep() const noexcept {
    return near_ == 0 && order_.empty() && lone_awake_.empty() && !lone_touch() &&
           !awake_changed_ && range_known_ && one_range_ && level_ == least_level_;
  }

  // Several islands (touched_islands.cpp).
  void divide_in_use() noexcept;
  void divide() noexcept;
  void find_range() noexcept;
  void lay_out() noexcept;
  void touch_islands() noexcept;
  void touch_lone(std::size_t exciter, std::size_t level) noexcept;
  [[nodiscard]] bool press_lone(std::size_t exciter) noexcept;
  [[nodiscard]] bool lone_touch() const noexcept {
    return !lone_near_.empty() || !pressed_.empty();
  }
  void look_at_pressed(bool look) noexcept;
  void touch_pressed() noexcept;
  void gather_pressed() noexcept;
  void let_go(std::size_t exciter) noexcept;
  [[nodiscard]] Group pack(std::size_t island, std::size_t level, bool in_body) noexcept;
  [[nodiscard]] bool few(std::size_t island) const noexcept;
  [[nodiscard]] std::size_t island_level(std::size_t island) const noexcept;
  [[nodiscard]] std::size_t island_work(std::size_t island) const noexcept;
  [[nodiscard]] std::size_t granted(std::size_t work, std::size_t level) const noexcept;
  void share_work() noexcept;

  // Exciters that stay away (touched_sleep.cpp).
  void list_awake() noexcept;
  void put_to_sleep() noexcept;
  [[nodiscard]] bool stays_away(std::size_t exciter, double samples) const noexcept;
  void catch_up(std::size_t exciter) const noexcept;
  void wake(std::size_t exciter) noexcept {
    if (sleep_[exciter].sleeps)
      wake_community(exciter);
    else if (pressed_.holds(exciter))
      let_go(exciter);
  }
  void wake_community(std::size_t exciter) noexcept;
  void wake_around(std::size_t exciter) noexcept;
  void wake_all() noexcept;
  void run(std::size_t exciter, const Stretch& whole) noexcept;
  std::size_t rest(std::size_t exciter, const Stretch& whole) noexcept;
  [[nodiscard]] bool steady(std::size_t exciter) const noexcept;
  void look_back() noexcept;
  /// The modes have changed otherwise than by the steps.
  void forget_foresight() noexcept { foreseen_ = islands_foreseen_ = heard_known_ = false; }
  void focus(std::size_t exciter) noexcept;
  struct PlaceArrays;
  [[nodiscard]] static PlaceView look_from(const ModesView& modes, const double* shape,
                                           const PlaceArrays& into) noexcept;
  void touch_alone(std::size_t exciter, const ModesView& modes, const PlaceView& place,
                   Foresight& foresight, bool& foreseen, std::size_t level) noexcept;
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
  std::vector<std::vector<double>> shape_, ear_shape_;
  std::vector<ModeArray> place_;                    ///< shapes over sqrt(m)
  std::vector<ModeArray> ear_real_, ear_imaginary_; ///< velocity there = these times the state
  ModeArray outer_, mean_; ///< forces over sqrt(m) from outside; modes' mean velocities
  /// What a PlaceView points to.
  struct PlaceArrays {
    double *push_real, *push_imaginary, *ahead_real, *ahead_imaginary;
  };
  struct PlaceMemory {
    ModeArray push_real, push_imaginary, ahead_real, ahead_imaginary;
    explicit PlaceMemory(std::size_t modes)
        : push_real(modes), push_imaginary(modes), ahead_real(modes), ahead_imaginary(modes) {}
    [[nodiscard]] PlaceArrays from(std::size_t mode) noexcept {
      return {push_real.data() + mode, push_imaginary.data() + mode, ahead_real.data() + mode,
              ahead_imaginary.data() + mode};
    }
  };
  PlaceMemory place_memory_; ///< of the one exciter that is near
  PlaceView place_view_{};
  Foresight foresight_;
  bool foreseen_ = false;    ///< foresight_ is of the state as it is
  ModesView whole_{};        ///< all modes in steps of a sample
  double heard_m_per_s_ = 0; ///< at the first ear, if heard_known_
  bool heard_known_ = false;
  bool has_outer_ = false, sounds_ = false, unsorted_ = true, tied_ = false, moved_ = false;
  bool coupled_ = false; ///< the system's coupling or place_view_ are those of close_
  std::array<double, kLevels> step_s_{}; ///< length of a step, by level
  std::size_t level_ = 0, least_level_ = 0, quiet_ = 0, near_ = 0;
  std::uint64_t clock_ = 0;
  /// Slots: in use and awake but for the lone ones; those of them that are near.
  std::vector<std::size_t> order_, close_;
  std::vector<char> like_the_one_before_; ///< by position in order_: the same but for its drive
  ContactSystem system_;                  ///< of one step, by position in close_
  std::vector<Push> pushes_;
  ModeArray matrix_, right_, other_;  ///< of solve_by_mode()
  std::vector<const double*> shapes_; ///< of a Group's contacts

  PlaceModes place_modes_;
  static constexpr std::size_t kFewModes = 4; ///< of a contact that is solved without vectors
  /// A place's modes where they are no more than that: by slot, side by side in memory.
  struct alignas(64) FewModes {
    std::uint32_t count = 0;
    std::array<std::uint32_t, kFewModes> mode{};
    std::array<double, kFewModes> shape{};
  };
  Islands in_use_;           ///< of all exciters in use: what may ever touch what
  Islands islands_;          ///< of those near, but for the lone ones
  bool divided_ = false;     ///< islands_ is of close_
  bool range_known_ = false; ///< and so are these: one island, and its modes, whole lanes
  bool one_range_ = true;
  std::size_t range_first_ = 0, range_end_ = 0;
  bool in_place_ = true;     ///< that is all
  std::size_t sounding_ = 0; ///< modes that are not left out
  std::size_t used_ = 0;     ///< exciters in use
  /// Exciters that no other shares a mode with and that move few: in use; of these, those that are
  /// awake and not in pressed_; of these, those that are near.
  std::vector<std::size_t> lone_, lone_awake_, lone_near_;
  PressedContacts pressed_;                    ///< lone contacts on one mode that go on quietly
  std::vector<std::size_t> sorted_;            ///< in use but for the lone ones
  std::array<std::size_t, kLevels> lone_at_{}; ///< how many are near, by the level they need
  std::size_t share_ = kMaxWork;               ///< products that an island's fine steps may take
  /// An island's modes in a row, with its contacts' shapes; parts of arrays, whole lanes.
  struct Packed {
    std::size_t at = 0, skip = 0, lanes = 0, shapes_at = 0, level = 0; ///< skip: lanes of others
    ContactSystem::Block block{};
    bool ready = false, in_body = false;
    PlaceView place{}; ///< of an only contact
    Foresight foresight{};
    bool foreseen = false;
  };
  std::vector<Packed> packed_;
  ModeArray before_real_, before_imaginary_; ///< state before the sample, where all modes ring
  const double *from_real_ = nullptr, *from_imaginary_ = nullptr; ///< from where islands go on
  PlaceMemory packed_places_;
  bool islands_foreseen_ = false; ///< the islands' foresights are of the state as it is
  ModalBody::Level packed_level_;
  ModeArray packed_real_, packed_imaginary_, packed_slowing_, packed_outer_, packed_shapes_;

  std::vector<FewModes> few_;
  /// By exciter: asleep since when, and from where its mass flies freely.
  struct Sleep {
    bool sleeps = false;
    std::uint64_t since = 0;
    double place_m = 0, velocity_m_per_s = 0;
  };
  std::vector<Sleep> sleep_;
  std::vector<std::size_t> community_;  ///< by exciter: its island in in_use_
  std::vector<std::uint64_t> wakes_at_; ///< by island in in_use_: asleep until then; 0: awake
  bool awake_changed_ = false;
};

} // namespace tactus::contact

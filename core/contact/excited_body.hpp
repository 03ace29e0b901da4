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

/// A vibrating body that masses strike and surfaces rub, and the velocity at its pickups.
///
/// The body is a list of modes (ModalBody). Each exciter has a slot, a contact point (the shape of
/// the modes there) and a law (ImpactLaw or FrictionLaw). step() advances everything by one sample.
///
/// Contacts near the surface are divided into islands that share no mode (Islands). For example,
/// bodies in one list of modes that do not touch at the moment are separate islands. Each island is
/// solved separately, in steps of its own length. Modes that no contact moves advance once a
/// sample.
///
/// All contacts of an island's step are solved together (ContactSystem); the second stage of
/// friction solves the system once more. The system has one unknown per contact, or one per mode if
/// there are fewer modes than contacts. Sums over contacts run in an order that depends on the
/// properties of the contacts and not on their slots: contacts that swap slots give the same bits.
///
/// Steps are 1, 1/2, ... 1/64 of a sample, as the stiffest contact of the island needs. A contact
/// too short even for 1/64 of a sample becomes an impulse with the restitution of its law.
/// Simultaneous impulses are solved together and never add energy.
///
/// Lengths in m, forces in N, times in s; positive velocities and forces point into the body. All
/// functions but the constructor are safe on the audio thread. A slot, pickup or mode out of range
/// is ignored; numbers are clamped to the ranges of exciter.hpp and of the laws. If a state becomes
/// NaN or exceeds kMaxState, the body is reset().
class ExcitedBody {
public:
  /// Allocates for at most this many modes, exciters (slots 0 ... exciters - 1) and pickups.
  explicit ExcitedBody(std::size_t max_modes, std::size_t exciters = 1, std::size_t pickups = 1,
                       simd::VectorSet widest = simd::kWidest);

  /// Sets the sample rate in Hz. A vibration of the body continues.
  void prepare(double sample_rate) noexcept;

  /// Sets the modes. Each mode keeps its energy, and each mass its distance from the surface.
  void set_modes(std::span<const Mode> modes) noexcept;
  /// Shape of the modes at an exciter's contact point: displacement there per modal displacement.
  /// Missing numbers are 0. Initially all 1.
  void set_contact_shape(std::size_t exciter, std::span<const double> shape) noexcept;
  /// Shape of the modes at a pickup, as in set_contact_shape().
  void set_pickup(std::size_t pickup, std::span<const double> shape) noexcept;

  /// Makes the exciter a free mass. Changing the law or the mass during contact adds no energy.
  void set_impact(std::size_t exciter, const ImpactLaw& law, double mass_kg) noexcept;
  /// Makes the exciter a rubbing surface.
  void set_friction(std::size_t exciter, const FrictionLaw& law) noexcept;
  /// Removes the exciter.
  void clear(std::size_t exciter) noexcept;

  /// Puts an impact's mass `gap_m` above the surface, with this velocity into the body.
  void launch_mass(std::size_t exciter, double gap_m, double velocity_m_per_s) noexcept;
  /// External force on an impact's mass, which stays until it is changed.
  void set_mass_force(std::size_t exciter, double force_n) noexcept;
  /// Normal force and velocity of a rubbing surface, which stay until they are changed.
  void rub(std::size_t exciter, double normal_force_n, double velocity_m_per_s) noexcept;
  /// Seeds the noise of a rough friction.
  void seed(std::size_t exciter, std::uint64_t seed) noexcept;
  /// Impulse on the body at the exciter's contact point, at once.
  void apply_impulse(std::size_t exciter, double impulse_ns) noexcept;
  /// Smallest number of steps per sample: 1, 2, 4 ... 64.
  void set_min_steps(unsigned steps) noexcept;

  /// Advances by one sample.
  void step() noexcept;
  /// Advances by the length of the shortest span. Gives the same bits as calling, for each sample,
  /// set_mass_force() (or rub()), step(), pickup_velocity(0) and force(exciter); takes less time
  /// if the exciter is the only one.
  void run_mass(std::size_t exciter, std::span<const double> force_n, std::span<double> output,
                std::span<double> contact_n) noexcept;
  void run_rub(std::size_t exciter, std::span<const double> velocity_m_per_s,
               std::span<const double> normal_force_n, std::span<double> output,
               std::span<double> friction_n) noexcept;
  /// Surface velocity at a pickup, m/s.
  [[nodiscard]] double pickup_velocity(std::size_t pickup = 0) const noexcept;
  /// Mean force of the exciter on the body in the last sample, N.
  [[nodiscard]] double force(std::size_t exciter) const noexcept {
    return pressed_.holds(exciter) ? pressed_.force(exciter) : exciters_[exciter].force_n;
  }
  /// State of an exciter, valid until the next call that changes the body.
  [[nodiscard]] const Exciter& exciter(std::size_t slot) const noexcept {
    if (sleep_[slot].sleeps)
      catch_up(slot);
    else if (pressed_.holds(slot))
      pressed_.read(slot, exciters_[slot], step_s_[0]);
    return exciters_[slot];
  }
  [[nodiscard]] std::size_t exciters() const noexcept { return exciters_.size(); }
  [[nodiscard]] const ModalBody& body() const noexcept { return body_; }
  /// Steps of the last sample; with several islands, the largest number.
  [[nodiscard]] unsigned steps() const noexcept { return 1U << level_; }
  /// Energy of modes, masses and contacts, J. It never grows without external forces.
  [[nodiscard]] double energy() const noexcept;
  /// True while modes vibrate or an exciter is near the surface.
  [[nodiscard]] bool active() const noexcept { return ringing_ || near_ > 0 || any_single_near(); }
  /// Sets the modes to rest and the masses 1 m above the surface.
  void reset() noexcept;

private:
  static constexpr std::size_t kMaxWork = std::size_t{1} << 17; ///< multiplications per sample
  static constexpr std::uint64_t kFlushPeriod = 64;             ///< samples
  void compute_step_lengths() noexcept;
  void store_depth(std::size_t exciter) noexcept;
  void store_depths() noexcept;
  void restore_depths() noexcept;
  void compute_point(std::size_t exciter) noexcept;
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
  /// Contacts that are solved together, the modes that they move and the level of their steps.
  struct Group {
    std::span<const std::size_t> slots;
    ModesView modes;
    std::size_t mode_count;
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
  /// True if every exciter sleeps, so that update_proximity() would change nothing.
  [[nodiscard]] bool all_sleep() const noexcept {
    return near_ == 0 && order_.empty() && single_awake_.empty() && !any_single_near() &&
           !awake_changed_ && range_known_ && one_range_ && level_ == min_level_;
  }

  // Several islands (excited_body_islands.cpp) and single contacts (excited_body_single.cpp).
  void find_islands_in_use() noexcept;
  void divide() noexcept;
  void find_range() noexcept;
  void assign_packed_ranges() noexcept;
  void step_islands() noexcept;
  void step_single(std::size_t exciter, std::size_t level) noexcept;
  struct SingleMode;
  void solve_single_impulse(Exciter& e, std::span<const std::uint32_t> modes, SingleMode* state,
                            double h) const noexcept;
  [[nodiscard]] bool step_single_impact(std::size_t exciter) noexcept;
  [[nodiscard]] bool any_single_near() const noexcept {
    return !single_near_.empty() || !pressed_.empty();
  }
  void update_pressed(bool measure) noexcept;
  void step_pressed() noexcept;
  void gather_pressed() noexcept;
  void release_pressed(std::size_t exciter) noexcept;
  [[nodiscard]] Group pack(std::size_t island, std::size_t level, bool in_body) noexcept;
  [[nodiscard]] bool is_single(std::size_t island) const noexcept;
  [[nodiscard]] std::size_t island_level(std::size_t island) const noexcept;
  [[nodiscard]] std::size_t island_work(std::size_t island) const noexcept;
  [[nodiscard]] std::size_t affordable_level(std::size_t work, std::size_t level) const noexcept;
  void distribute_work() noexcept;

  // Exciters out of reach of the surface (excited_body_sleep.cpp).
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
  /// To be called when the modes have changed other than by a step.
  void invalidate_prediction() noexcept { predicted_ = islands_predicted_ = output_known_ = false; }
  void update_views() noexcept;
  void prepare_single_contact(std::size_t exciter) noexcept;
  struct PointArrays;
  [[nodiscard]] static PointView make_point_view(const ModesView& modes, const double* shape,
                                                 const PointArrays& into) noexcept;
  void step_only_contact(std::size_t exciter, const ModesView& modes, const PointView& point,
                         Prediction& prediction, bool& predicted, std::size_t level) noexcept;
  [[nodiscard]] ModesView view(std::size_t level, std::size_t first, std::size_t end) noexcept;
  [[nodiscard]] ModesView view() noexcept { return view(level_, range_first_, range_end_); }
  [[nodiscard]] double step_length() const noexcept { return step_s_[level_]; }
  /// Multiplications that the solution of a step takes.
  [[nodiscard]] static std::size_t work(std::size_t contacts, std::size_t modes) noexcept {
    const std::size_t small = std::min(contacts, modes), big = std::max(contacts, modes);
    return small * small * (big + small) / 2 + 4 * small * big;
  }

  ModalBody body_;
  const BodyKernel* kernel_;
  /// Mutable: exciter() updates an exciter that sleeps or is kept in pressed_.
  mutable std::vector<Exciter> exciters_;
  std::vector<std::vector<double>> shape_, pickup_shape_;
  std::vector<ModeArray> point_shape_; ///< shapes over sqrt(m)
  /// By pickup: velocity = pickup_real . Re z + pickup_imaginary . Im z.
  std::vector<ModeArray> pickup_real_, pickup_imaginary_;
  ModeArray mean_; ///< mean velocities of the modes
  /// The arrays of a PointView, and their memory.
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
  PointMemory point_memory_; ///< memory of the only exciter that is near
  PointView point_view_{};
  Prediction prediction_;
  bool predicted_ = false;    ///< prediction_ belongs to the current state
  ModesView all_modes_{};     ///< all modes in steps of a sample
  double output_m_per_s_ = 0; ///< velocity at the first pickup, if output_known_
  bool output_known_ = false;
  bool ringing_ = false, order_stale_ = true, has_identical_ = false, drives_changed_ = false;
  bool coupled_ = false; ///< the system's coupling or point_view_ belongs to near_slots_
  std::array<double, kLevels> step_s_{}; ///< length of a step, by level
  std::size_t level_ = 0, min_level_ = 0, coarse_count_ = 0, near_ = 0;
  std::uint64_t clock_ = 0;
  /// order_: slots in use and awake, without single contacts. near_slots_: those of order_ that are
  /// near the surface.
  std::vector<std::size_t> order_, near_slots_;
  std::vector<char> same_as_previous_; ///< by index in order_: differs from the exciter before it
                                       ///< at most in its drive
  ContactSystem system_;               ///< system of one step, by index in near_slots_
  std::vector<PointForce> forces_;
  ModeArray matrix_, right_, other_;  ///< arrays of solve_by_mode()
  std::vector<const double*> shapes_; ///< shapes of the contacts of a Group

  PointModes point_modes_;
  /// A single contact is alone in its island and moves at most this many modes.
  static constexpr std::size_t kFewModes = 4;
  /// The first kFewModes modes of a contact point, contiguous in memory. `count` may be larger.
  struct alignas(64) FewModes {
    std::uint32_t count = 0;
    std::array<std::uint32_t, kFewModes> mode{};
    std::array<double, kFewModes> shape{};
  };
  Islands in_use_;             ///< islands of all exciters in use
  Islands islands_;            ///< islands of the near exciters, single contacts excluded
  bool islands_valid_ = false; ///< islands_ belongs to near_slots_
  bool range_known_ = false;   ///< the next three members belong to near_slots_
  bool one_range_ = true;      ///< near_slots_ are one island, with modes close together
  std::size_t range_first_ = 0, range_end_ = 0; ///< its range of modes, in multiples of kModeLanes
  bool single_range_ = true;                    ///< one_range_, and no single contact is near
  std::size_t active_modes_ = 0;                ///< modes that vibrate (ModalBody::set_modes())
  std::size_t used_ = 0;                        ///< exciters in use
  /// single_: single contacts in use. single_awake_: those of single_ that are awake and not in
  /// pressed_. single_near_: those of single_awake_ that are near.
  std::vector<std::size_t> single_, single_awake_, single_near_;
  PressedContacts pressed_;         ///< sustained single contacts on one mode
  std::vector<std::size_t> sorted_; ///< slots in use, single contacts excluded
  /// Number of near single contacts, by the level they need.
  std::array<std::size_t, kLevels> single_at_level_{};
  std::size_t share_ = kMaxWork; ///< multiplications that the fine steps of an island may take
  /// Part of an island in the packed arrays: its modes contiguously, and its contacts' shapes.
  struct Packed {
    std::size_t at = 0;        ///< index of its first number
    std::size_t skip = 0;      ///< leading lanes that hold no mode of the island
    std::size_t lanes = 0;     ///< numbers, a multiple of kModeLanes
    std::size_t shapes_at = 0; ///< index of the first number of its shapes
    std::size_t level = 0;     ///< level of the coefficients
    ContactSystem::Block block{};
    bool ready = false, in_body = false; ///< in_body: the state stays in the body's arrays
    PointView point{};                   ///< view of the contact, if it is the only one
    Prediction prediction{};
    bool predicted = false;
  };
  std::vector<Packed> packed_;
  ModeArray before_real_, before_imaginary_; ///< state before the sample, if some modes ring freely
  const double *from_real_ = nullptr, *from_imaginary_ = nullptr; ///< state before the sample
  PointMemory packed_points_;
  bool islands_predicted_ = false; ///< the predictions of the islands belong to the current state
  ModalBody::Level packed_level_;
  ModeArray packed_real_, packed_imaginary_, packed_decay_over_omega_, packed_shapes_;

  std::vector<FewModes> few_;
  /// An exciter that cannot reach the surface for a while: its mass flies freely from this state.
  struct Sleep {
    bool sleeps = false;
    std::uint64_t since = 0; ///< clock_ when it fell asleep
    double position_m = 0, velocity_m_per_s = 0;
  };
  std::vector<Sleep> sleep_;               ///< by exciter
  std::vector<std::size_t> island_of_;     ///< by exciter: its island in in_use_
  std::vector<std::uint64_t> sleep_until_; ///< by island in in_use_: clock_ at which it wakes; 0:
                                           ///< awake
  bool awake_changed_ = false;
};

} // namespace tactus::contact

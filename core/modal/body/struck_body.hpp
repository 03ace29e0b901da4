#pragma once

#include "core/dsp/joined_steps.hpp"
#include "core/modal/body/body_model.hpp"
#include "core/modal/body/timed_queue.hpp"
#include "core/modal/contact/pulse.hpp"
#include "core/modal/radiation/delay_line.hpp"
#include "core/modal/radiation/direct_sound.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tactus::modal {

/// A striker: a ball in Hertz contact, or a mass with a contact law of its own.
struct Striker {
  double mass_kg = 0.00710, radius_m = 0.006, youngs_modulus_pa = 206e9, poisson = 0.29;
  double stiffness = 0, exponent = 1.5, loss_s_per_m = 0; ///< stiffness above 0 overrides Hertz
  double restitution = 1; ///< on a rigid wall; below 1 it sets the loss
};

/// A surface that rubs the body, such as a bow.
struct Rub {
  bool placed = false; ///< else it rubs at the force point
  SurfacePoint point;
  Vec3 direction{0, 0, 1}; ///< of length 1, along the body's surface: that of positive velocity
  contact::FrictionLaw law;
};

/// One strike.
struct Hit {
  SurfacePoint point;
  Vec3 direction{0, 0, 1}; ///< of length 1; the striker moves against it
  double speed_m_per_s = 1;
  bool falls = false; ///< under gravity: the striker bounces until it lies still
};

/// A virtual body that is struck, pushed, pressed and rubbed, with its sound at up to four
/// listeners.
///
/// While something touches the body, ContactSolver computes contacts and modes together, sample by
/// sample. Otherwise the modes ring in ModeBank, which is much cheaper. A body on a board touches
/// it for as long as anything moves, so that it rings in the solver; strikes that exceed the budget
/// (kMaxCoupledWork) are pulses that excite the bank besides. Sound passes through DirectSound and
/// a DelayLine for each listener.
///
/// Threads: process(), hit() and all setters belong to one thread (or are called in turn).
/// publish() may be called from another thread; the new model is taken at the beginning of a block.
/// Nothing but prepare(), publish() and levels() allocates.
class StruckBody {
public:
  StruckBody() = default;
  ~StruckBody();
  StruckBody(const StruckBody&) = delete;
  StruckBody& operator=(const StruckBody&) = delete;

  /// Allocates. A model sounds only if it was made for the same sample rate.
  void prepare(double sample_rate);

  /// Hands over a model. A model that has not been taken yet is dropped. `same_body`: the motion
  /// continues in the new model; else it begins at rest and the old body fades out.
  void publish(std::unique_ptr<BodyModel> model, bool same_body);
  /// Takes a published model now. Not while process() runs.
  void adopt() noexcept;
  /// The present model; null before the first.
  [[nodiscard]] const BodyModel* model() const noexcept { return model_.get(); }

  void set_striker(const Striker& striker) noexcept { striker_ = striker; }
  [[nodiscard]] const Striker& striker() const noexcept { return striker_; }
  /// Strikes the body now. False if there is no body or the speed is not above 0.
  bool hit(const Hit& hit) noexcept;
  /// Sets the point where the external force and the driven striker act.
  void set_point(const SurfacePoint& point, const Vec3& direction) noexcept;
  /// The point after all scheduled events.
  [[nodiscard]] const SurfacePoint& point() const noexcept { return requested_point_; }
  /// Sets the friction law and the point of the rubbing surface; it slides there if it is rubbing.
  void set_rub(const Rub& rub) noexcept;
  /// Ends all contacts and fades the sound out.
  void reset() noexcept;

  /// The same at a sample on the clock of process(), or at once if that is past. At most
  /// kMaxScheduled events wait; one more applies the first of them now.
  void schedule_hit(const Hit& hit, std::int64_t sample) noexcept;
  void schedule_point(const SurfacePoint& point, const Vec3& direction,
                      std::int64_t sample) noexcept;
  void schedule_rub(const Rub& rub, std::int64_t sample) noexcept;
  /// The rub after all scheduled events.
  [[nodiscard]] const Rub& requested_rub() const noexcept { return requested_rub_; }
  void schedule_reset(std::int64_t sample) noexcept;
  /// Sets the sample at which the next process() begins; without it, where the last one ended.
  void begin_block(std::int64_t sample) noexcept { clock_ = sample; }
  [[nodiscard]] std::int64_t clock() const noexcept { return clock_; }
  static constexpr std::size_t kMaxScheduled = 512;
  /// The most modes times coupled contacts. A strike beyond it is a pulse, unless it is the only
  /// one, so that any number of strikes on a large body is computed in time.
  static constexpr std::size_t kMaxCoupledWork = 8192;
  /// The most coupled contacts at once; a strike beyond them is a pulse.
  static constexpr std::size_t kMaxCoupled = 16;
  /// The most work of scheduled strikes that begin within kBudgetSamples, in modes plus a quarter
  /// of the modes for each listener. Further strikes begin kBudgetSamples later, in order. With two
  /// listeners: on 20 000 modes one strike, on 10 000 modes two.
  static constexpr std::size_t kMaxStartingWork = 40000;
  static constexpr std::int64_t kBudgetSamples = 64;
  /// A body of more modes takes at most one new force point and one new point of the rub, the
  /// newest, within kBudgetSamples.
  static constexpr std::size_t kMaxUnthrottledModes = 4096;

  /// The levels of the `limit` lowest modes, by frequency: dB from full scale at the loudest
  /// listener, at least -120. Allocates.
  [[nodiscard]] std::vector<double> levels(std::size_t limit);

  struct Options {
    bool coupled = true;       ///< else strikes are half-sine pulses (Pulse)
    bool driven = false;       ///< `height` of process() moves a striker above the force point
    bool doppler = false;      ///< a moving listener hears the pitch change
    double spring_n_per_m = 0; ///< above 0: the driven striker meets this spring, without sound
    double gain = 0.01;        ///< full scales for 1 Pa (for `none`: for 1 m/s)
    bool soft_limit = false;   ///< the sound goes through soft_clip() after the gain
    double cull_db = 90;
    std::uint64_t seed = 1; ///< of a rub's roughness
  };
  /// A new gain is smoothed while something sounds; in silence it is applied at once.
  void set_options(const Options& options) noexcept;
  [[nodiscard]] const Options& options() const noexcept { return options_; }
  /// Modes that the last strike left out as inaudible.
  [[nodiscard]] std::size_t culled() const noexcept { return culled_; }
  /// Contacts and pulses at present, without resting contacts.
  [[nodiscard]] std::size_t contacts() const noexcept;
  /// Strikers in the air between two bounces.
  [[nodiscard]] std::size_t flights() const noexcept;

  static constexpr double kGravity = 9.80665; ///< m/s^2

  /// The rubbing surface, sample by sample: its normal force, N, its velocity, m/s, and the
  /// resulting friction force, N. Empty spans: nothing rubs.
  template <class S> struct Rubbing {
    std::span<const S> normal_force, velocity;
    std::span<S> friction;
  };
  /// Computes a block of force_out.size() samples. `force`: N, at the force point. `height`: of the
  /// driven striker above it, m; held readings are joined (JoinedSteps). `out`: up to kMaxListeners
  /// spans, overwritten. `force_out`: the force of strikers and hands, N. Input and output may
  /// share memory. Any input is safe: NaN counts as 0, forces are limited to 1e6 N.
  template <class S>
  void process(std::span<const S> force, std::span<const S> height,
               std::span<const std::span<S>> out, std::span<S> force_out,
               const Rubbing<S>& rubbing = {}) noexcept;

private:
  static constexpr std::size_t kChunk = 64;
  struct PulseImpact {
    Hit hit;
    Pulse pulse;
    double age_s = 0;
    bool active = false;
  };
  struct Recording {
    std::size_t hit = 0;
    double speed_m_per_s = 0, age_s = 0;
    bool active = false, released = false;
    std::size_t release_left = ModeBank::kRelease; ///< samples, when released
  };
  using Recordings = std::array<Recording, kMaxContacts>;
  using ChannelBlock = std::array<std::array<float, kChunk>, kMaxListeners>;
  /// A coupled strike, and the state of its striker between bounces.
  struct CoupledImpact {
    Hit hit;
    Striker striker;
    bool bounces = false, in_air = false;
    double landing_speed_m_per_s = 0;
    std::uint64_t landing = 0; ///< sample
  };
  struct Chunk {
    std::array<float, kChunk> force{}, height{}, contact{}, normal{}, velocity{}, friction{};
    ChannelBlock output{}, released{};
    std::array<std::array<float, kChunk>, kMaxContacts> pulse{};
  };
  /// A scheduled event.
  struct Event {
    enum class Kind { kHit, kPoint, kRub, kReset };
    Kind kind = Kind::kReset;
    Hit hit; ///< of kPoint: point and direction only
    Striker striker;
    Rub rub;
  };
  void schedule(const Event& event, std::int64_t sample) noexcept;
  void apply_due_events() noexcept;
  [[nodiscard]] bool has_event_by(Event::Kind kind, std::int64_t sample) noexcept;
  void apply_event(const Event& event) noexcept;
  void move_events(const BodyModel& before) noexcept;
  bool strike(const Hit& hit, const Striker& striker) noexcept;
  void run(std::size_t frames) noexcept;
  [[nodiscard]] std::size_t run_coupled(std::size_t from, std::size_t frames) noexcept;
  [[nodiscard]] std::size_t run_uncoupled(std::size_t from, std::size_t frames) noexcept;
  void begin_driven() noexcept;
  void begin_rub() noexcept;
  void set_rub_point() noexcept;
  void drive_rub(std::size_t sample) noexcept;
  [[nodiscard]] std::size_t driven_slot() const noexcept { return model_->settings.voices; }
  [[nodiscard]] std::size_t rub_slot() const noexcept { return model_->settings.voices + 1; }
  void run_bank_beside_contact(std::size_t from, std::size_t to) noexcept;
  void take_over_contacts(BodyModel& before) noexcept;
  void start_flights() noexcept;
  void start_flight(std::size_t slot) noexcept;
  void begin_landed_contacts() noexcept;
  void find_next_landing() noexcept;
  void finish(std::size_t frames) noexcept;
  void enter_contact() noexcept;
  void leave_contact() noexcept;
  void make_pulses(std::size_t frames) noexcept;
  void set_pulse_gains(std::size_t slot, std::span<double> gain) noexcept;
  void continue_pulses() noexcept;
  [[nodiscard]] contact::ImpactLaw law(const Striker& striker, double speed,
                                       const SurfacePoint& point) const noexcept;
  // A body that rests on a board: struck_body_resting.cpp.
  [[nodiscard]] bool has_resting_contacts() const noexcept {
    return !model_->resting_contacts.empty();
  }
  [[nodiscard]] std::size_t active_strikes() const noexcept;
  void begin_resting_contacts() noexcept;
  [[nodiscard]] bool has_settled() const noexcept;
  void strike_coupled(std::size_t slot, const Hit& hit, const Striker& striker) noexcept;
  [[nodiscard]] bool strike_pulse(std::size_t slot, const Hit& hit, const Striker& striker,
                                  double max_mass_ratio) noexcept;
  void strike_recording(std::size_t slot, const Hit& hit) noexcept;
  void play_recordings(const BodyModel& model, Recordings& recordings, std::size_t frames,
                       ChannelBlock& output) noexcept;
  [[nodiscard]] std::size_t free_slot() noexcept;
  void update_point_gains() noexcept;

  double sample_rate_ = 48000;
  std::unique_ptr<BodyModel> model_;
  struct Handover {
    std::unique_ptr<BodyModel> model;
    bool same_body = false;
    Handover* next = nullptr;
    int owners = 1; ///< each calls retire() once
  };
  void drop_retired() noexcept;
  void retire(Handover* body) noexcept;
  /// An exchanged body, until the last of its sound has reached the listeners.
  struct FadingBody {
    Handover* body = nullptr;
    std::array<DelayLine, kMaxListeners> delay{};
    Recordings recordings{};
    DirectSound direct;
    std::size_t left = 0;      ///< samples
    bool before_delay = false; ///< it sounds through the delay lines of the present body
  };
  /// A slot for a body that fades out: a free one, or that of the body nearest to its end.
  [[nodiscard]] FadingBody& fading_slot() noexcept;
  void fade_unmatched(Handover* before) noexcept;
  void map_points_to_new_shape() noexcept;
  /// What adopt() changes when a new model takes over.
  struct Transition {
    bool same_body = false;  ///< its motion continues
    bool resolved = false;   ///< ... in a table whose modes were solved again (ModeShare)
    bool in_contact = false; ///< ... and its contacts continue
    bool in_silence = false; ///< nothing sounds: all changes take effect at once
    bool gliding = false;    ///< the old model's weights were gliding
  };
  [[nodiscard]] bool continue_states(BodyModel& next, const Transition& change) noexcept;
  void snap_point_to_surface() noexcept;
  void continue_direct(Handover* before, const Transition& change) noexcept;
  void mix_coupled_output(std::size_t segment_begin, std::size_t sample) noexcept;
  void add_fading_before_delay(std::size_t frames) noexcept;
  void fade_out(Handover* before, bool glides) noexcept;
  void add_fading(std::size_t listener_count, std::size_t frames) noexcept;
  std::array<FadingBody, 3> fading_{};
  // The direct sound of forces: struck_body_direct.cpp.
  template <class Work> void for_each_model(Work&& work) noexcept;
  template <class Work> void for_each_part(Work&& work) noexcept;
  void build_contact_kernels(std::size_t slot, const SurfacePoint& point,
                             const Vec3& direction) noexcept;
  void build_pulse_kernels(std::size_t slot, const SurfacePoint& point,
                           const Vec3& direction) noexcept;
  void build_point_kernels() noexcept;
  void take_over_direct(Handover* before, bool moving) noexcept;
  void use_current_kernels() noexcept;
  void retire_unused() noexcept;
  void carry_over_direct(BodyModel& before, const ContactSolver& solver) noexcept;
  void add_direct_contacts(std::size_t at) noexcept;
  void add_direct_samples(std::size_t at, std::size_t sample) noexcept;
  void finish_direct(std::size_t from, std::size_t to, const Glide& glide) noexcept;
  std::atomic<Handover*> incoming_{nullptr}, retired_{nullptr};
  /// Earlier models whose kernels still sound, and the model of each part of the glide.
  std::array<Handover*, 4> previous_models_{};
  std::array<BodyModel*, 3> part_model_{};
  DirectSound direct_;
  bool point_kernels_valid_ = false; ///< the force inlet's kernels are those of the point
  Striker striker_;
  Options options_;
  TimedQueue<Event, kMaxScheduled> events_;
  std::int64_t budget_begin_ = 0;                                            ///< sample
  std::size_t starting_work_ = 0;                                            ///< since then
  std::int64_t point_moved_ = -kBudgetSamples, rub_moved_ = -kBudgetSamples; ///< samples
  std::int64_t clock_ = 0; ///< sample that process() begins with
  SurfacePoint point_, requested_point_;
  Vec3 point_direction_{0, 0, 1};
  bool point_set_ = false;
  Rub rub_, requested_rub_;
  bool in_solver_ = false;
  std::array<PulseImpact, kMaxContacts> pulses_{};
  Recordings recordings_{};
  std::array<CoupledImpact, kMaxContacts> impacts_{};
  static constexpr std::uint64_t kNever = ~std::uint64_t{0};
  std::uint64_t now_ = 0, next_landing_ = kNever; // samples
  std::size_t culled_ = 0;
  std::uint64_t strike_count_ = 0;
  std::array<std::uint64_t, kMaxContacts> strike_order_{};
  JoinedSteps hand_steps_{}; // of the height
  double last_height_ = 0;
  double hand_scale_ = 1; // of the depth of a hand that presses while the body changes
  double last_force_ = 0; ///< of the inlet
  Chunk chunk_;
  std::array<DelayLine, kMaxListeners> delay_{};
  double smooth_gain_ = 0.01;
  static constexpr std::size_t kSilence = 64; ///< samples of zeros that count as silence
  std::size_t silent_samples_ = kSilence;     ///< that have gone out since the last sound
};

} // namespace tactus::modal

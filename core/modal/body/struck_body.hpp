#pragma once

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

/// What strikes: a ball by Hertz, or a contact law given outright.
struct Striker {
  double mass_kg = 0.00710, radius_m = 0.006, youngs_modulus_pa = 206e9, poisson = 0.29;
  double stiffness = 0, exponent = 1.5, loss_s_per_m = 0; ///< stiffness above 0 overrides Hertz
  double restitution = 1; ///< on a resting wall; below 1 it sets the loss
};

/// A surface that rubs the body, such as a bow.
struct Rub {
  bool placed = false; ///< else it rubs at the point
  SurfacePoint point;
  Vec3 direction{0, 0, 1}; ///< of length 1, along the body's surface: where its velocity counts to
  contact::FrictionLaw law;
};

/// One blow.
struct Hit {
  SurfacePoint point;
  Vec3 direction{0, 0, 1}; ///< of length 1; the blow goes against it
  double speed_m_per_s = 1;
  bool falls = false; ///< by its weight: it comes back under gravity until it lies
};

/// A body that is struck, pushed and pressed, and heard: model, contacts, mode bank and the ways to
/// the listeners. New models are handed over between threads and taken at a block's beginning.
///
/// Contacts run coupled with the body in ContactSolver, sample by sample; everything else rings in
/// ModeBank. A body that rests on a board touches it for as long as anything moves: it rings in the
/// solver, and the bank has what crowded strikes excite beside it. process() and hit() belong to
/// one thread (or are called in turn), publish() to another.
class StruckBody {
public:
  StruckBody() = default;
  ~StruckBody();
  StruckBody(const StruckBody&) = delete;
  StruckBody& operator=(const StruckBody&) = delete;

  /// Allocates. Models must be made for the same sample rate to sound.
  void prepare(double sample_rate);

  /// Hands over a model; the one that it replaces before the audio path has taken it is dropped.
  /// `same_body`: it goes on ringing, else it is silent and the old body, ringing on, is faded out.
  void publish(std::unique_ptr<BodyModel> model, bool same_body);
  /// Takes a published model now. Not while process() runs.
  void adopt() noexcept;
  /// The model at work; null before the first.
  [[nodiscard]] const BodyModel* model() const noexcept { return model_.get(); }

  void set_striker(const Striker& striker) noexcept { striker_ = striker; }
  [[nodiscard]] const Striker& striker() const noexcept { return striker_; }
  /// A blow now. False when there is no body.
  bool hit(const Hit& hit) noexcept;
  /// Where the outer force and the led striker meet the body.
  void set_point(const SurfacePoint& point, const Vec3& direction) noexcept;
  /// Where they meet when all that is scheduled has happened.
  [[nodiscard]] const SurfacePoint& point() const noexcept { return requested_point_; }
  /// What rubs the body, and where; a rub under way changes its law and slides on to the place.
  void set_rub(const Rub& rub) noexcept;
  void reset() noexcept;

  /// The same at a sample on the clock of process(), at once for a sample that is over. At most
  /// kMaxScheduled wait; one more makes the first happen now.
  void schedule_hit(const Hit& hit, std::int64_t sample) noexcept;
  void schedule_point(const SurfacePoint& point, const Vec3& direction,
                      std::int64_t sample) noexcept;
  void schedule_rub(const Rub& rub, std::int64_t sample) noexcept;
  /// What rubs when all that is scheduled has happened.
  [[nodiscard]] const Rub& requested_rub() const noexcept { return requested_rub_; }
  void schedule_reset(std::int64_t sample) noexcept;
  /// The next process() begins at this sample; else where the last one ended.
  void begin_block(std::int64_t sample) noexcept { clock_ = sample; }
  [[nodiscard]] std::int64_t clock() const noexcept { return clock_; }
  static constexpr std::size_t kMaxScheduled = 512;
  /// Modes times contacts that are followed coupled at once; a blow beyond it is a pulse, unless
  /// it is the only one, so that any number of blows on a large body stays in time.
  static constexpr std::size_t kMaxCoupledWork = 8192;
  /// Contacts that are followed coupled at once; a strike beyond them is a pulse.
  static constexpr std::size_t kMaxCoupled = 16;
  /// Modes, and a quarter of them for each listener, of scheduled strikes that begin within
  /// kBudgetSamples; what comes beyond it begins so much later, in order. On 20 000 modes one
  /// strike, on 10 000 modes three.
  static constexpr std::size_t kMaxStartingWork = 40000;
  static constexpr std::int64_t kBudgetSamples = 64;
  /// A body of more modes takes one new force point, and one new place of what rubs, within
  /// kBudgetSamples, the newest.
  static constexpr std::size_t kMaxUnthrottledModes = 4096;

  /// Levels in dB from full scale at the loudest listener, of the lowest modes by frequency; -120
  /// for what is at rest. Allocates.
  [[nodiscard]] std::vector<double> levels(std::size_t limit);

  struct Options {
    bool coupled = true; ///< else blows are pulses of known shape
    bool driven = false; ///< the second inlet holds a striker's height above the point
    bool doppler = false;
    double spring_n_per_m = 0; ///< above 0: the led striker feels this spring, nothing sounds
    double gain = 0.01;        ///< full scales for 1 Pa (for `none`: for 1 m/s)
    double cull_db = 90;
  };
  /// A new gain is smoothed while something sounds; in silence it holds at once.
  void set_options(const Options& options) noexcept;
  [[nodiscard]] const Options& options() const noexcept { return options_; }
  /// Modes that the last blow left out as inaudible, and those that ring now.
  [[nodiscard]] std::size_t culled() const noexcept { return culled_; }
  [[nodiscard]] std::size_t contacts() const noexcept;
  /// Strikers that are in the air between two bounces.
  [[nodiscard]] std::size_t flights() const noexcept;

  static constexpr double kGravity = 9.80665; ///< m/s^2

  /// How the surface that rubs presses, N, and moves, m/s, sample by sample, and its force along
  /// the body's surface, N. Empty spans: nothing rubs.
  template <class S> struct Rubbing {
    std::span<const S> normal_force, velocity;
    std::span<S> friction;
  };
  /// out: kMaxListeners spans or fewer, overwritten, N samples each; force_out in N.
  /// `force` N, `height` m above the point. Input and output may share memory.
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
  using Sound = std::array<std::array<float, kChunk>, kMaxListeners>;
  /// A coupled blow, and where its striker is when it bounces.
  struct CoupledImpact {
    Hit hit;
    Striker striker;
    bool bounces = false, in_air = false;
    double landing_speed_m_per_s = 0;
    std::uint64_t landing = 0; ///< on the clock of samples
  };
  struct Chunk {
    std::array<float, kChunk> force{}, height{}, contact{}, normal{}, velocity{}, friction{};
    Sound output{}, released{};
    std::array<std::array<float, kChunk>, kMaxContacts> pulse{};
  };
  /// What waits for its sample.
  struct Event {
    enum class Kind { kHit, kPoint, kRub, kReset };
    Kind kind = Kind::kReset;
    Hit hit; ///< of a point: its place and direction
    Striker striker;
    Rub rub;
  };
  void schedule(const Event& event, std::int64_t sample) noexcept;
  void carry_out_due() noexcept;
  [[nodiscard]] bool has_event_by(Event::Kind kind, std::int64_t sample) noexcept;
  void carry_out(const Event& event) noexcept;
  void move_events(const BodyModel& before) noexcept;
  bool strike(const Hit& hit, const Striker& striker) noexcept;
  void run(std::size_t frames) noexcept;
  [[nodiscard]] std::size_t in_contact(std::size_t from, std::size_t frames) noexcept;
  [[nodiscard]] std::size_t in_flight(std::size_t from, std::size_t frames) noexcept;
  void begin_driven() noexcept;
  void begin_rub() noexcept;
  void set_rub_point() noexcept;
  void drive_rub(std::size_t sample) noexcept;
  [[nodiscard]] std::size_t driven_slot() const noexcept { return model_->settings.voices; }
  [[nodiscard]] std::size_t rub_slot() const noexcept { return model_->settings.voices + 1; }
  void ring_bank(std::size_t from, std::size_t to) noexcept;
  void take_over_contacts(BodyModel& before) noexcept;
  void start_flights() noexcept;
  void start_flight(std::size_t slot) noexcept;
  void land() noexcept;
  void find_next_landing() noexcept;
  void finish(std::size_t frames) noexcept;
  void enter_contact() noexcept;
  void leave_contact() noexcept;
  void make_pulses(std::size_t frames) noexcept;
  void set_pulse_gains(std::size_t slot, std::span<double> gain) noexcept;
  void continue_pulses() noexcept;
  [[nodiscard]] contact::ImpactLaw law(const Striker& striker, double speed,
                                       const SurfacePoint& point) const noexcept;
  // A body that rests on a board: struck_body_rest.cpp.
  [[nodiscard]] bool resting_contacts() const noexcept { return !model_->resting_contacts.empty(); }
  [[nodiscard]] std::size_t active_strikes() const noexcept;
  void begin_resting_contacts() noexcept;
  [[nodiscard]] bool has_settled() const noexcept;
  void strike_coupled(std::size_t slot, const Hit& hit, const Striker& striker) noexcept;
  [[nodiscard]] bool strike_pulse(std::size_t slot, const Hit& hit, const Striker& striker,
                                  double max_mass_ratio) noexcept;
  void strike_recording(std::size_t slot, const Hit& hit) noexcept;
  void play_recordings(const BodyModel& model, Recordings& recordings, std::size_t frames,
                       Sound& output) noexcept;
  [[nodiscard]] std::size_t free_slot() noexcept;
  void update_point_gains() noexcept;

  double sample_rate_ = 48000;
  std::unique_ptr<BodyModel> model_;
  struct Handover {
    std::unique_ptr<BodyModel> model;
    bool same_body = false;
    Handover* next = nullptr;
    int owners = 1; ///< what retires it, each once
  };
  void drop_retired() noexcept;
  void retire(Handover* body) noexcept;
  /// A body that has been exchanged, until the last of its sound has reached the listeners.
  struct FadingBody {
    Handover* body = nullptr;
    std::array<DelayLine, kMaxListeners> delay{};
    Recordings recordings{};
    DirectSound direct;
    std::size_t left = 0;      ///< samples
    bool before_delay = false; ///< of the present delay lines, with the present body
  };
  /// Room for a body that leaves: of more than there is room for, the one nearest to its end goes.
  [[nodiscard]] FadingBody& fading_slot() noexcept;
  void fade_unmatched(Handover* before) noexcept;
  void follow_surface() noexcept;
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
  /// Models before, while their kernels are heard, and the kernels of each part of the glide.
  std::array<Handover*, 4> previous_models_{};
  std::array<BodyModel*, 3> part_{};
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
  double last_height_ = 0;
  double last_force_ = 0; ///< of the inlet
  Chunk chunk_;
  std::array<DelayLine, kMaxListeners> delay_{};
  double smooth_gain_ = 0.01;
  static constexpr std::size_t kSilence = 64; ///< samples of zeros that count as silence
  std::size_t silent_samples_ = kSilence;     ///< that have gone out since the last sound
};

} // namespace tactus::modal

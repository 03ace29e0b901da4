#pragma once

#include "core/modal/body/direct_mixer.hpp"
#include "core/modal/body/event_schedule.hpp"
#include "core/modal/body/fading_bodies.hpp"
#include "core/modal/body/hand.hpp"
#include "core/modal/body/model_handover.hpp"
#include "core/modal/body/output_stage.hpp"
#include "core/modal/body/rubbing_surface.hpp"
#include "core/modal/body/strikers.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace tactus::modal {

/// A virtual body that is struck, pushed, pressed and rubbed, with its sound at up to four
/// listeners.
///
/// While something touches the body, ContactSolver computes contacts and modes together, sample by
/// sample. Otherwise the modes ring in ModeBank, which is much cheaper. A body on a board touches
/// the board for as long as anything moves, so that it rings in the solver; strikes that exceed the
/// budget (Strikers::kMaxCoupledWork) are pulses that excite the bank in addition. Sound passes
/// through DirectSound and a DelayLine for each listener.
///
/// process() runs its parts in this order. EventSchedule passes due events to Strikers, Hand and
/// RubbingSurface, which begin contacts in the solver. Solver or bank, with DirectMixer, compute
/// the body's sound. FadingBodies and OutputStage compute from it the sound at the listeners.
///
/// Threads: process(), apply() and all setters belong to one thread (or are called in turn).
/// publish() may be called from another thread; the new model is taken at the beginning of a block.
/// Nothing but prepare(), publish() and levels() allocates.
class StruckBody {
public:
  /// Allocates. A model sounds only if it was made for the same sample rate.
  void prepare(double sample_rate);

  /// Hands over a model. A model that has not been taken yet is dropped. `same_body`: the motion
  /// continues in the new model; else it begins at rest and the old body fades out.
  void publish(std::unique_ptr<BodyModel> model, bool same_body) {
    handover_.publish(std::move(model), same_body);
  }
  /// Takes a published model now. Not to be called while process() runs.
  void adopt() noexcept;
  /// The present model; null before the first.
  [[nodiscard]] const BodyModel* model() const noexcept { return model_.get(); }

  /// Sets the striker of hit(), which is also the driven striker.
  void set_striker(const Striker& striker) noexcept { striker_ = striker; }
  [[nodiscard]] const Striker& striker() const noexcept { return striker_; }
  /// Strikes the body now. False if there is no body or the speed is not above 0.
  bool hit(const Hit& hit) noexcept;
  void apply(const Event& event) noexcept;
  /// Applies an event at a sample on the clock of process(), or at once if that sample is past. At
  /// most EventSchedule::kMaxScheduled events wait; if there is one more, the first of them is
  /// applied now.
  void schedule(const Event& event, std::int64_t sample) noexcept;
  void schedule(const Hit& hit, std::int64_t sample) noexcept {
    schedule(Strike{hit, striker_}, sample);
  }
  /// The force point and the rub after all scheduled events.
  [[nodiscard]] SurfacePoint point() const noexcept;
  [[nodiscard]] Rub rub() const noexcept;
  /// Sets the sample at which the next process() begins; without this call it begins where the last
  /// one ended.
  void begin_block(std::int64_t sample) noexcept { clock_ = sample; }
  [[nodiscard]] std::int64_t clock() const noexcept { return clock_; }

  /// The levels of the `limit` lowest modes, by frequency: dB from full scale at the loudest
  /// listener, at least -120. Allocates.
  [[nodiscard]] std::vector<double> levels(std::size_t limit);

  struct Options {
    bool coupled = true;       ///< false: strikes are half-sine pulses (Pulse)
    bool driven = false;       ///< `height` of process() moves a striker above the force point
    bool doppler = false;      ///< a moving listener hears the pitch change
    double spring_n_per_m = 0; ///< above 0: the driven striker meets this spring, without sound
    double gain = 0.01;        ///< full scales for 1 Pa (for `none`: for 1 m/s)
    bool soft_limit = false;   ///< the sound goes through soft_clip() after the gain
    double cull_db = 90;
    std::uint64_t seed = 1; ///< seed of a rub's roughness noise
  };
  /// A new gain is smoothed while something sounds; in silence it is applied at once.
  void set_options(const Options& options) noexcept;
  [[nodiscard]] const Options& options() const noexcept { return options_; }
  /// Modes that were last left out as inaudible.
  [[nodiscard]] std::size_t culled() const noexcept { return model_ ? model_->culled : 0; }
  /// Contacts and pulses at present, without resting contacts.
  [[nodiscard]] std::size_t contacts() const noexcept;
  /// Strikers in the air between two bounces.
  [[nodiscard]] std::size_t flights() const noexcept { return strikers_.flights(); }

  /// The rubbing surface, sample by sample: its normal force, N, its velocity, m/s, and the
  /// resulting friction force, N. Empty spans: nothing rubs.
  template <class S> struct Rubbing {
    std::span<const S> normal_force, velocity;
    std::span<S> friction;
  };
  /// Computes a block of force_out.size() samples. `force`: N, at the force point. `height`: of the
  /// driven striker above the force point, m; held readings are joined (JoinedSteps). `out`: up to
  /// kMaxListeners spans, overwritten. `force_out`: the force of strikers and hands, N. Input and
  /// output may share memory. Any input is safe: NaN counts as 0, forces are limited to 1e6 N.
  template <class S>
  void process(std::span<const S> force, std::span<const S> height,
               std::span<const std::span<S>> out, std::span<S> force_out,
               const Rubbing<S>& rubbing = {}) noexcept;

private:
  struct Chunk {
    std::array<float, kChunk> force{}, height{}, normal{}, velocity{}; ///< in
    std::array<float, kChunk> contact{}, friction{};                   ///< out
    ChannelBlock output{};
  };
  void carry_out(const Strike& strike) noexcept;
  void carry_out(const ForcePoint& point) noexcept;
  void carry_out(const Rub& rub) noexcept { rub_.set(rub, point_, model_.get(), direct_); }
  void carry_out(const Reset& reset) noexcept;
  void leave_contact() noexcept;
  void update_force_point() noexcept;
  // struck_body_run.cpp
  [[nodiscard]] bool hand_touches() const noexcept {
    return options_.driven && options_.spring_n_per_m == 0;
  }
  void run(std::size_t frames) noexcept;
  [[nodiscard]] std::size_t run_coupled(std::size_t from, std::size_t frames) noexcept;
  [[nodiscard]] std::size_t run_uncoupled(std::size_t from, std::size_t frames) noexcept;
  void step_contacts(std::size_t from, std::size_t sample) noexcept;
  void run_bank(std::size_t from, std::size_t to, const float* force, ChannelBlock& out,
                std::size_t out_from) noexcept;
  void run_bank_beside_contact(std::size_t from, std::size_t to) noexcept;
  void mix_coupled_output(std::size_t from, std::size_t sample) noexcept;
  void add_direct_samples(std::size_t at, std::size_t sample) noexcept;
  // struck_body_adopt.cpp
  /// The effects of an exchange of models by adopt().
  struct Transition {
    bool same_body = false;  ///< the motion of the body continues
    bool resolved = false;   ///< the motion continues in a table whose modes were solved again
                             ///< (ModeShare)
    bool in_contact = false; ///< the contacts of the body continue
    bool in_silence = false; ///< nothing sounds: all changes take effect at once
    bool gliding = false;    ///< the old model's weights were gliding
  };
  [[nodiscard]] Transition transition_to(const ModelHandover::Use& next) noexcept;
  void move_points(const BodyModel& before, const Transition& change) noexcept;
  void fade_out(const ModelHandover::Use& before, bool gliding) noexcept;
  void snap_point_to_surface() noexcept;

  double sample_rate_ = 48000;
  bool prepared_ = false;
  ModelHandover handover_;
  ModelHandover::Use model_;
  Options options_;
  Striker striker_;
  std::int64_t clock_ = 0; ///< sample that process() begins with
  EventSchedule schedule_;
  ForcePoint point_;
  bool point_set_ = false;
  Strikers strikers_;
  Hand hand_;
  RubbingSurface rub_;
  DirectMixer direct_;
  FadingBodies fading_;
  OutputStage output_;
  Chunk chunk_;
};

} // namespace tactus::modal

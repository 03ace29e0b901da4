#pragma once

#include "core/modal/body/pulse_voices.hpp"
#include "core/modal/body/recording_voices.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::modal {

/// The strikers of a body, each in a slot: in contact, in the air between two bounces, as a pulse,
/// or as a recording. If no slot is free, a new strike takes the slot of the oldest.
class Strikers {
public:
  /// Maximum of modes times coupled contacts. A strike beyond it is a pulse, unless it is the only
  /// strike, so that any number of strikes on a large body is computed in time.
  static constexpr std::size_t kMaxCoupledWork = 8192;
  /// Maximum number of coupled contacts at once; a strike beyond it is a pulse.
  static constexpr std::size_t kMaxCoupled = 16;

  /// `coupled` false: the strike is a pulse, if striker and body allow it. `cull_db`: for pulses.
  void strike(const Strike& strike, bool coupled, double cull_db, BodyModel& body,
              DirectMixer& direct) noexcept;
  [[nodiscard]] PulseVoices& pulses() noexcept { return pulses_; }
  [[nodiscard]] const PulseVoices& pulses() const noexcept { return pulses_; }
  [[nodiscard]] RecordingVoices& recordings() noexcept { return recordings_; }

  /// Advances the clock by this number of samples.
  void advance(std::size_t samples) noexcept { now_ += samples; }
  /// Samples until the next striker lands; kNever: none is in the air.
  [[nodiscard]] std::uint64_t landing_in() const noexcept {
    return next_landing_ == kNever ? kNever : next_landing_ - std::min(now_, next_landing_);
  }
  static constexpr std::uint64_t kNever = ~std::uint64_t{0};
  /// Begins the contacts of the strikers that have landed.
  void land(BodyModel& body, DirectMixer& direct) noexcept;
  /// Contacts have ended: falling strikers are in the air, unless they lie still.
  void lift_off(const BodyModel& body) noexcept;
  [[nodiscard]] std::size_t flights() const noexcept;

  /// All contacts have ended; strikers in the air still land.
  void end_contacts() noexcept;
  /// Drops the strikers in contact and in the air.
  void drop_contacts() noexcept;
  void move_points(const PointMap& map) noexcept;
  /// Continues the contacts in the solver of a new model of the same body.
  void take_over_contacts(BodyModel& now, const BodyModel& before) const noexcept;
  /// Continues flights and pulses on a new model, which may have fewer slots.
  void continue_on(BodyModel& body) noexcept;

private:
  /// A coupled strike, and the state of its striker between bounces.
  struct CoupledImpact {
    Strike strike;
    bool bounces = false, in_air = false;
    double landing_speed_m_per_s = 0;
    std::uint64_t landing = 0; ///< sample
  };
  [[nodiscard]] std::size_t free_slot(BodyModel& body) noexcept;
  void strike_coupled(std::size_t slot, const Strike& strike, BodyModel& body,
                      DirectMixer& direct) noexcept;
  void lift_off(std::size_t slot, const BodyModel& body) noexcept;
  void find_next_landing() noexcept;

  std::array<CoupledImpact, kMaxContacts> impacts_{};
  PulseVoices pulses_;
  RecordingVoices recordings_;
  std::array<std::uint64_t, kMaxContacts> order_{}; ///< order of the strikes in the slots
  std::uint64_t count_ = 0;                         ///< number of strikes
  std::uint64_t now_ = 0, next_landing_ = kNever;   ///< samples
};

} // namespace tactus::modal

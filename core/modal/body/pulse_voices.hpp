#pragma once

#include "core/modal/body/direct_mixer.hpp"
#include "core/modal/body/point_map.hpp"
#include "core/modal/contact/pulse.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace tactus::modal {

/// Strikes that are half-sine pulses (Pulse), in the strikes' slots. They excite the bank through
/// the drives after that of the external force.
class PulseVoices {
public:
  /// False if the striker is too heavy for a single pulse (Pulse::mass_ratio). Modes quieter than
  /// the loudest by `cull_db` are left out.
  [[nodiscard]] bool strike(std::size_t slot, const Strike& strike, double max_mass_ratio,
                            double cull_db, BodyModel& body, DirectMixer& direct) noexcept;
  [[nodiscard]] bool active(std::size_t slot) const noexcept { return voices_[slot].active; }
  void end(std::size_t slot) noexcept { voices_[slot].active = false; }
  void end_all() noexcept { voices_ = {}; }
  [[nodiscard]] std::size_t count() const noexcept;

  /// Computes the samples of a chunk, and adds them to `contact`.
  void begin_chunk(const BodyModel& body, std::span<float> contact) noexcept;
  /// The samples that begin_chunk() computed, N; null if there is no pulse.
  [[nodiscard]] const float* force(std::size_t slot) const noexcept {
    return voices_[slot].active ? force_[slot].data() : nullptr;
  }
  void end_chunk(const BodyModel& body) noexcept;

  void move_points(const PointMap& map) noexcept;
  /// Continues on a new model of the body, which may have fewer slots.
  void continue_on(BodyModel& body) noexcept;

private:
  struct Voice {
    Hit hit;
    Pulse pulse;
    double age_s = 0;
    bool active = false;
  };
  static void set_gains(std::size_t slot, std::span<double> gain, BodyModel& body) noexcept;

  std::array<Voice, kMaxContacts> voices_{};
  std::array<std::array<float, kChunk>, kMaxContacts> force_{};
};

} // namespace tactus::modal

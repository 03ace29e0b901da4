#pragma once

#include "core/modal/body/body_model.hpp"

#include <array>
#include <cstddef>

namespace tactus::modal {

/// The recordings (RawTable) that strikes on a body play, in the strikes' slots.
class RecordingVoices {
public:
  /// Plays the recording of the nearest hit point.
  void strike(std::size_t slot, const BodyModel& body, const Vec3& position,
              double speed_m_per_s) noexcept;
  [[nodiscard]] bool active(std::size_t slot) const noexcept { return voices_[slot].active; }
  void end(std::size_t slot) noexcept { voices_[slot].active = false; }
  /// Fades all of them out.
  void release() noexcept;
  /// Adds `frames` samples to `output`.
  void play(const BodyModel& body, std::size_t frames, ChannelBlock& output) noexcept;

private:
  struct Voice {
    std::size_t hit = 0;
    double speed_m_per_s = 0, age_s = 0;
    bool active = false, released = false;
    std::size_t release_left = ModeBank::kRelease; ///< samples, when released
  };
  std::array<Voice, kMaxContacts> voices_{};
};

} // namespace tactus::modal

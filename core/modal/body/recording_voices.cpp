#include "core/modal/body/recording_voices.hpp"

#include <limits>

namespace tactus::modal {

void RecordingVoices::strike(std::size_t slot, const BodyModel& body, const Vec3& position,
                             double speed_m_per_s) noexcept {
  const RawTable& table = body.loaded->table.raw;
  std::size_t nearest = 0;
  double minimum = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < table.hits; ++i)
    if (const double distance = norm(table.hit_m[i] - position); distance < minimum) {
      minimum = distance;
      nearest = i;
    }
  voices_[slot] = {nearest, speed_m_per_s, 0, true};
}

void RecordingVoices::release() noexcept {
  for (Voice& voice : voices_)
    voice.released = true;
}

void RecordingVoices::play(const BodyModel& body, std::size_t frames,
                           ChannelBlock& output) noexcept {
  const RawTable& table = body.loaded->table.raw;
  for (Voice& voice : voices_) {
    if (!voice.active)
      continue;
    for (std::size_t n = 0; n < frames && voice.release_left > 0; ++n) {
      double level = voice.speed_m_per_s;
      if (voice.released)
        level *= ModeBank::release_share(voice.release_left--);
      for (std::size_t l = 0; l < body.settings.listeners; ++l)
        output[l][n] +=
            static_cast<float>(level * body.raw[l].pressure(table, voice.hit, voice.age_s));
      voice.age_s += 1 / body.settings.sample_rate;
    }
    voice.active = voice.release_left > 0 && voice.age_s < body.raw[0].end_s(table);
  }
}

} // namespace tactus::modal

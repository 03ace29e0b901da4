#include "core/modal/body/pulse_voices.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::modal {

bool PulseVoices::strike(std::size_t slot, const Strike& strike, double max_mass_ratio,
                         double cull_db, BodyModel& body, DirectMixer& direct) noexcept {
  const auto& [hit, striker] = strike;
  std::vector<double>& gain = body.scratch;
  body.gains(hit.point, hit.direction, gain);
  double rigid = 0;
  for (const double b : body.rigid_gains(hit.point, hit.direction))
    rigid += b * b;
  const Pulse pulse =
      find_pulse(body.impact_law(striker, hit.speed_m_per_s, hit.point), striker.mass_kg,
                 hit.speed_m_per_s, striker.restitution,
                 {gain, body.rate, rigid, body.residual_compliance(hit.point), body.band});
  if (pulse.mass_ratio > max_mass_ratio)
    return false;
  voices_[slot] = {hit, pulse, 0, true};
  double loudest = 0;
  std::array<double, kPulseBands> envelope{}; // envelope at each band's lowest frequency
  for (std::size_t i = 0; i < kPulseBands; ++i)
    envelope[i] = Pulse::envelope(pulse_band_begin(i) * pulse.duration_s);
  std::vector<double>& level = body.scratch_level;
  for (std::size_t k = 0; k < body.audible_modes; ++k) {
    level[k] = std::abs(gain[k]) * envelope[body.band[k]] * body.loudness[k];
    loudest = std::max(loudest, level[k]);
  }
  const double minimum = loudest * math::exp10(-cull_db / 20);
  body.culled = 0;
  for (std::size_t k = 0; k < body.audible_modes; ++k)
    if (level[k] < minimum) {
      gain[k] = 0;
      ++body.culled;
    }
  set_gains(slot, gain, body);
  direct.build_pulse_kernels(slot, hit.point, hit.direction);
  return true;
}

void PulseVoices::set_gains(std::size_t slot, std::span<double> gain, BodyModel& body) noexcept {
  for (std::size_t k = 0; k < gain.size(); ++k)
    gain[k] *= body.pulse_gain[k];
  body.bank.set_gain(1 + slot, std::span<const double>(gain).first(body.audible_modes));
}

std::size_t PulseVoices::count() const noexcept {
  return static_cast<std::size_t>(std::count_if(voices_.begin(), voices_.end(),
                                                [](const Voice& voice) { return voice.active; }));
}

void PulseVoices::begin_chunk(const BodyModel& body, std::span<float> contact) noexcept {
  const double rate = body.settings.sample_rate;
  for (std::size_t i = 0; i < body.settings.voices; ++i) {
    Voice& voice = voices_[i];
    if (!voice.active)
      continue;
    // Each sample holds the mean force of its interval, so that the impulse is exact.
    const auto passed = [&](double t) {
      return 0.5 * (1 - math::cos(std::numbers::pi * std::min(t / voice.pulse.duration_s, 1.0)));
    };
    for (std::size_t n = 0; n < contact.size(); ++n) {
      const double next = voice.age_s + 1 / rate;
      force_[i][n] =
          static_cast<float>(voice.pulse.impulse_n_s * rate * (passed(next) - passed(voice.age_s)));
      voice.age_s = next;
      contact[n] += force_[i][n];
    }
  }
}

void PulseVoices::end_chunk(const BodyModel& body) noexcept {
  for (Voice& voice : std::span(voices_).first(body.settings.voices))
    voice.active = voice.active && voice.age_s < voice.pulse.duration_s;
}

void PulseVoices::move_points(const PointMap& map) noexcept {
  for (Voice& voice : voices_)
    map.move(voice.hit);
}

void PulseVoices::continue_on(BodyModel& body) noexcept {
  for (std::size_t i = 0; i < voices_.size(); ++i) {
    Voice& voice = voices_[i];
    voice.active = voice.active && i < body.settings.voices;
    if (!voice.active)
      continue;
    body.gains(voice.hit.point, voice.hit.direction, body.scratch);
    set_gains(i, body.scratch, body);
    body.build_pulse_kernels(i, voice.hit.point, voice.hit.direction, body.scratch);
  }
}

} // namespace tactus::modal

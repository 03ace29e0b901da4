#include "core/modal/body/fading_bodies.hpp"

#include <algorithm>
#include <utility>

namespace tactus::modal {

void FadingBodies::prepare(double sample_rate) {
  for (FadingBody& body : bodies_) {
    body.model = {};
    body.direct.prepare(sample_rate);
    modal::prepare(body.delay, sample_rate);
  }
}

/// A free entry, or the entry of the body that is closest to its end.
FadingBodies::FadingBody& FadingBodies::free_entry() noexcept {
  FadingBody* entry = &bodies_[0];
  for (FadingBody& other : bodies_)
    if (!other.model || (entry->model && other.left < entry->left))
      entry = &other;
  return *entry;
}

void FadingBodies::fade_unmatched(const ModelHandover::Use& before) noexcept {
  FadingBody& entry = free_entry();
  entry.model = before;
  entry.before_delay = true;
  entry.left = ModeBank::kRelease;
}

void FadingBodies::fade_out(const ModelHandover::Use& before, const RecordingVoices& recordings,
                            DirectSound& direct, DelayLines& delay) noexcept {
  FadingBody& entry = free_entry();
  entry.model = before;
  entry.before_delay = false;
  entry.recordings = recordings;
  entry.recordings.release();
  std::swap(entry.direct, direct);
  direct.clear();
  std::swap(entry.delay, delay);
  for (DelayLine& line : delay)
    line.clear();
  BodyModel& model = *before;
  model.bank.release();
  const double rate = model.settings.sample_rate;
  const double travel = *std::max_element(model.delay_s.begin(), model.delay_s.end()) * rate;
  entry.left = ModeBank::kRelease + static_cast<std::size_t>(std::min(travel, 0.1 * rate)) +
               2 * DelayLine::kHalf;
}

/// Runs the bank of an earlier model.
void FadingBodies::ring(BodyModel& model, std::size_t frames) noexcept {
  std::array<float*, kMaxListeners> out{};
  for (std::size_t l = 0; l < model.settings.listeners; ++l)
    out[l] = sound_[l].data();
  model.bank.process({}, out, frames);
}

void FadingBodies::count_down(FadingBody& body, std::size_t frames) noexcept {
  body.left -= std::min(body.left, frames);
  if (body.left == 0)
    body.model = {};
}

void FadingBodies::add_before_delay(ChannelBlock& output, std::size_t listeners,
                                    std::size_t frames) noexcept {
  for (FadingBody& body : bodies_) {
    if (!body.model || !body.before_delay)
      continue;
    ring(*body.model, frames);
    for (std::size_t l = 0; l < std::min(body.model->settings.listeners, listeners); ++l)
      for (std::size_t n = 0; n < frames; ++n)
        output[l][n] += sound_[l][n];
    count_down(body, frames);
  }
}

void FadingBodies::add_after_delay(ChannelBlock& output, std::size_t listeners,
                                   std::size_t frames) noexcept {
  for (FadingBody& body : bodies_) {
    if (!body.model || body.before_delay)
      continue;
    const BodyModel& m = *body.model;
    ring(*body.model, frames);
    if (m.uses_recordings)
      body.recordings.play(m, frames, sound_);
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      body.direct.finish(l, std::span(sound_[l]).first(frames), Glide());
    for (std::size_t l = 0; l < std::min(m.settings.listeners, listeners); ++l) {
      body.delay[l].run(sound_[l].data(), frames);
      for (std::size_t n = 0; n < frames; ++n)
        output[l][n] += sound_[l][n];
    }
    count_down(body, frames);
  }
}

} // namespace tactus::modal

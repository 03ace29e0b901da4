#include "core/modal/struck_body.hpp"

#include <algorithm>
#include <utility>

/// How a StruckBody gives way to another: what waited, and what still rings.
namespace tactus::modal {

/// What waits happens to the new body, at the same positions.
void StruckBody::move_events(const BodyModel& before) noexcept {
  for (std::size_t i = 0; i < events_.size(); ++i) {
    Hit& hit = events_[i].hit;
    const bool along_normal = hit.direction == hit.place.normal;
    hit.place = model_->nearest(before.settings.size * hit.place.position);
    if (along_normal)
      hit.direction = hit.place.normal;
    Rub& rub = events_[i].rub;
    rub.place = model_->nearest(before.settings.size * rub.place.position);
    rub.direction = along_surface(rub.place.normal, rub.direction);
  }
}

/// What is left of a body is deleted by another thread.
void StruckBody::retire(Handover* body) noexcept {
  if (!body)
    return;
  body->next = retired_.load(std::memory_order_relaxed);
  while (!retired_.compare_exchange_weak(body->next, body, std::memory_order_acq_rel)) {
  }
}

/// The body before rings on by itself while it is faded out. Of more than there is room for, the
/// one that is nearest to its end goes.
void StruckBody::leave(Handover* before, bool glides) noexcept {
  if (glides)
    direct_.settle(before->model->bank.glide(0));
  settle_direct();
  Recordings recordings = std::exchange(recordings_, {});
  BodyModel* const model = before->model.get();
  const bool sounds = model && model->settings.sample_rate == sample_rate_ &&
                      (silent_samples_ < kSilence || !model->bank.asleep());
  if (!sounds) {
    direct_.clear();
    return retire(before);
  }
  Leaving* room = &leaving_[0];
  for (Leaving& other : leaving_)
    if (other.body == nullptr || (room->body != nullptr && other.left < room->left))
      room = &other;
  retire(room->body);
  room->body = before;
  room->recordings = recordings;
  for (Recording& r : room->recordings)
    r.released = true;
  std::swap(room->direct, direct_);
  direct_.clear();
  std::swap(room->delay, delay_);
  for (DelayLine& line : delay_)
    line.clear();
  model->bank.release();
  const double travel =
      *std::max_element(model->delay_s.begin(), model->delay_s.end()) * sample_rate_;
  room->left = ModeBank::kRelease + static_cast<std::size_t>(std::min(travel, 0.1 * sample_rate_)) +
               2 * DelayLine::kHalf;
}

void StruckBody::add_leaving(std::size_t listener_count, std::size_t frames) noexcept {
  for (Leaving& body : leaving_) {
    if (!body.body)
      continue;
    BodyModel& m = *body.body->model;
    std::array<float*, kMostListeners> out{};
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      out[l] = chunk_.released[l].data();
    m.bank.process({}, out, frames);
    if (m.plays_raw)
      play_raw(m, body.recordings, frames, chunk_.released);
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      body.direct.finish(l, std::span(chunk_.released[l]).first(frames), Glide());
    for (std::size_t l = 0; l < std::min(m.settings.listeners, listener_count); ++l) {
      body.delay[l].run(chunk_.released[l].data(), frames);
      for (std::size_t n = 0; n < frames; ++n)
        chunk_.heard[l][n] += chunk_.released[l][n];
    }
    body.left -= std::min(body.left, frames);
    if (body.left == 0)
      retire(std::exchange(body.body, nullptr));
  }
}

} // namespace tactus::modal

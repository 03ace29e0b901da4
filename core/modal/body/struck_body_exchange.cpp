#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <utility>

/// How a StruckBody gives way to another: what waited, and what still rings.
namespace tactus::modal {
namespace {

/// Of the same contacts and listeners.
bool have_like_kernels(const BodyModel& one, const BodyModel& two) noexcept {
  return one.settings.sample_rate == two.settings.sample_rate &&
         one.settings.voices == two.settings.voices && one.rests.size() == two.rests.size() &&
         one.settings.listeners == two.settings.listeners;
}

} // namespace

void StruckBody::publish(std::unique_ptr<BodyModel> model, bool same_body) {
  drop_retired();
  auto* next = new Handover{std::move(model), same_body, nullptr};
  delete incoming_.exchange(next, std::memory_order_acq_rel);
}

void StruckBody::adopt() noexcept {
  Handover* next = incoming_.exchange(nullptr, std::memory_order_acq_rel);
  if (!next)
    return;
  const bool follows = next->same_body && model_ && next->model->loaded->follows(*model_->loaded);
  const bool goes_on =
      follows || (next->same_body && model_ && model_->loaded == next->model->loaded);
  bool unmatched = false;
  const bool touched =
      goes_on && coupled_now_ && next->model->settings.sample_rate == model_->settings.sample_rate;
  if (!touched)
    leave_contact();
  // In silence everything holds at once.
  const bool in_silence =
      !model_ || (!touched && silent_samples_ >= kSilence && model_->bank.asleep());
  if (goes_on && in_silence) {
    next->model->bank.set_clock(model_->bank.clock());
  } else if (follows) {
    unmatched = next->model->succeed(*model_, touched);
  } else if (touched) {
    next->model->continue_touched(*model_);
  } else if (goes_on) {
    next->model->continue_from(*model_);
  } else {
    blows_ = {};
    next_landing_ = kNever;
    pulses_ = {};
    if (model_)
      next->model->bank.set_clock(model_->bank.clock());
  }
  const bool glides = model_ && model_->bank.glide(0).moving();
  std::swap(model_, next->model);
  if (follows)
    follow_surface();
  if (unmatched)
    fade_unmatched(next);
  if (touched) {
    if (next->model->rests.empty() && rests())
      model_->solver.rest_rigid(); // where it was without a board is its equilibrium now
    take_over_contacts(*next->model);
  }
  if (!goes_on && next->model)
    move_events(*next->model);
  if (!goes_on)
    leave(next, glides);
  for (std::size_t l = 0; l < kMaxListeners; ++l) {
    delay_[l].set(model_->delay_s[l] * sample_rate_, options_.doppler, !goes_on || in_silence);
  }
  if (!goes_on && rub_.placed && next->model) {
    rub_.place = model_->nearest(next->model->settings.size * rub_.place.position);
    rub_.direction = along_surface(rub_.place.normal, rub_.direction);
  }
  if (!point_set_ || !goes_on) {
    const Surface& surface = model_->loaded->surface;
    if (!surface.empty()) {
      // Until a point is given: what lies nearest to the user.
      const Vec3 there = point_set_ ? point_.position
                                    : 0.5 * (surface.lowest() + surface.highest()) +
                                          Vec3{0, 0, surface.diagonal()};
      point_ = surface.nearest(there);
      point_direction_ = point_.normal;
    } else {
      point_ = {};
    }
  }
  renew_point();
  for (std::size_t i = model_->settings.voices; i < kMostContacts; ++i)
    blows_[i] = {};
  find_next_landing();
  continue_pulses();
  if (goes_on) {
    if (!in_silence && have_like_kernels(*model_, *next->model)) {
      take_over_direct(next, glides);
    } else {
      if (in_silence) {
        direct_.clear();
      } else { // what has been given goes on, to the listeners that stay
        direct_.settle(next->model->bank.glide(0));
        direct_.clear_from(model_->settings.listeners);
      }
      settle_direct();
      retire(next);
    }
  }
  requested_point_ = point_;
  for (std::size_t i = 0; i < events_.size(); ++i)
    if (events_[i].kind == Event::Kind::kPoint)
      requested_point_ = events_[i].hit.place;
}

void StruckBody::take_over_contacts(BodyModel& before) noexcept {
  BodyModel& m = *model_;
  const auto go_on = [&](std::size_t slot, std::size_t old_slot, const SurfacePoint& place,
                         const Vec3& direction, bool held = false) {
    if (!before.solver.contact(old_slot).active)
      return;
    m.gains(place, direction, m.scratch);
    const auto rigid =
        held && !m.recoils(place) ? BodyModel::RigidGain{} : m.rigid_gains(place, direction);
    m.solver.take_over(slot, before.solver, old_slot, m.scratch, rigid);
    m.aim_contact(slot, place, direction);
  };
  begin_rests();
  const std::size_t voices = before.settings.voices;
  for (std::size_t i = 0; i < std::min(led_slot(), voices); ++i)
    go_on(i, i, blows_[i].hit.place, blows_[i].hit.direction);
  go_on(led_slot(), voices, point_, point_direction_);
  go_on(rub_slot(), voices + 1, rub_.place, -rub_.direction, true);
}

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
  if (!body || --body->holders > 0)
    return;
  body->next = retired_.load(std::memory_order_relaxed);
  while (!retired_.compare_exchange_weak(body->next, body, std::memory_order_acq_rel)) {
  }
}

StruckBody::Leaving& StruckBody::room_to_leave() noexcept {
  Leaving* room = &leaving_[0];
  for (Leaving& other : leaving_)
    if (other.body == nullptr || (room->body != nullptr && other.left < room->left))
      room = &other;
  retire(std::exchange(room->body, nullptr));
  return *room;
}

/// Modes of the table before that have no successor, being released in its bank, are heard by the
/// delay lines of the present body.
void StruckBody::fade_unmatched(Handover* before) noexcept {
  Leaving& room = room_to_leave();
  ++before->holders;
  room.body = before;
  room.ahead = true;
  room.recordings = {};
  room.left = ModeBank::kRelease;
}

/// Places on the surface are the same material points of a body that has another shape.
void StruckBody::follow_surface() noexcept {
  const Surface& surface = model_->loaded->surface;
  if (surface.empty())
    return;
  const auto follow = [&](SurfacePoint& place, Vec3* direction) {
    const bool along_normal = direction && *direction == place.normal;
    place = surface.on(place.triangle, place.weight[1], place.weight[2]);
    if (along_normal)
      *direction = place.normal;
  };
  follow(point_, &point_direction_);
  follow(requested_point_, nullptr);
  for (Rub* rub : {&rub_, &requested_rub_})
    if (rub->placed) {
      follow(rub->place, nullptr);
      rub->direction = along_surface(rub->place.normal, rub->direction);
    }
  for (Blow& blow : blows_)
    follow(blow.hit.place, &blow.hit.direction);
  for (PulseBlow& blow : pulses_)
    follow(blow.hit.place, &blow.hit.direction);
  for (std::size_t i = 0; i < events_.size(); ++i) {
    follow(events_[i].hit.place, &events_[i].hit.direction);
    follow(events_[i].rub.place, nullptr);
    events_[i].rub.direction = along_surface(events_[i].rub.place.normal, events_[i].rub.direction);
  }
}

/// The body before rings on by itself while it is faded out.
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
  Leaving* const room = &room_to_leave();
  room->body = before;
  room->ahead = false;
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

void StruckBody::add_leaving_ahead(std::size_t frames) noexcept {
  for (Leaving& body : leaving_) {
    if (!body.body || !body.ahead)
      continue;
    BodyModel& m = *body.body->model;
    std::array<float*, kMaxListeners> out{};
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      out[l] = chunk_.released[l].data();
    m.bank.process({}, out, frames);
    const std::size_t listeners =
        model_ ? std::min(m.settings.listeners, model_->settings.listeners) : 0;
    for (std::size_t l = 0; l < listeners; ++l)
      for (std::size_t n = 0; n < frames; ++n)
        chunk_.heard[l][n] += chunk_.released[l][n];
    body.left -= std::min(body.left, frames);
    if (body.left == 0)
      retire(std::exchange(body.body, nullptr));
  }
}

void StruckBody::add_leaving(std::size_t listener_count, std::size_t frames) noexcept {
  for (Leaving& body : leaving_) {
    if (!body.body || body.ahead)
      continue;
    BodyModel& m = *body.body->model;
    std::array<float*, kMaxListeners> out{};
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

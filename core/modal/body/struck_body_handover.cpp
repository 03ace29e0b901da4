#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <utility>

/// StruckBody: how a new model takes over from the present one, and how an old body fades out.
namespace tactus::modal {
namespace {

/// True if both have the same slots of contacts and the same number of listeners.
bool have_compatible_kernels(const BodyModel& one, const BodyModel& two) noexcept {
  return one.settings.sample_rate == two.settings.sample_rate &&
         one.settings.voices == two.settings.voices &&
         one.resting_contacts.size() == two.resting_contacts.size() &&
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
  Transition change;
  change.resolved = next->same_body && model_ && next->model->loaded->follows(*model_->loaded);
  change.same_body =
      change.resolved || (next->same_body && model_ && model_->loaded == next->model->loaded);
  change.in_contact = change.same_body && in_solver_ &&
                      next->model->settings.sample_rate == model_->settings.sample_rate;
  if (!change.in_contact)
    leave_contact();
  change.in_silence =
      !model_ || (!change.in_contact && silent_samples_ >= kSilence && model_->bank.idle());
  const bool unmatched = continue_states(*next->model, change);
  change.gliding = model_ && model_->bank.glide(0).moving();
  std::swap(model_, next->model);
  if (change.resolved)
    map_points_to_new_shape();
  if (unmatched)
    fade_unmatched(next);
  if (change.in_contact) {
    if (next->model->resting_contacts.empty() && has_resting_contacts())
      model_->solver.reset_rigid(); // the present position is the equilibrium on the new board
    take_over_contacts(*next->model);
  }
  if (!change.same_body && next->model)
    move_events(*next->model);
  if (!change.same_body)
    fade_out(next, change.gliding);
  for (std::size_t l = 0; l < kMaxListeners; ++l) {
    delay_[l].set(model_->delay_s[l] * sample_rate_, options_.doppler,
                  !change.same_body || change.in_silence);
  }
  if (!change.same_body && rub_.placed && next->model) {
    rub_.point = model_->nearest(next->model->settings.size * rub_.point.position);
    rub_.direction = along_surface(rub_.point.normal, rub_.direction);
  }
  if (!point_set_ || !change.same_body)
    snap_point_to_surface();
  update_point_gains();
  for (std::size_t i = model_->settings.voices; i < kMaxContacts; ++i)
    impacts_[i] = {};
  find_next_landing();
  continue_pulses();
  if (change.same_body)
    continue_direct(next, change);
  requested_point_ = point_;
  for (std::size_t i = 0; i < events_.size(); ++i)
    if (events_[i].kind == Event::Kind::kPoint)
      requested_point_ = events_[i].hit.point;
}

/// Moves the present model's motion to the next one. True if modes without a successor are left in
/// the present model's bank, to be faded out.
bool StruckBody::continue_states(BodyModel& next, const Transition& change) noexcept {
  if (change.same_body && change.in_silence) {
    next.bank.set_clock(model_->bank.clock());
  } else if (change.resolved) {
    return next.continue_modes_from(*model_, change.in_contact);
  } else if (change.in_contact) {
    next.continue_in_contact(*model_);
  } else if (change.same_body) {
    next.continue_from(*model_);
  } else {
    impacts_ = {};
    next_landing_ = kNever;
    pulses_ = {};
    if (model_)
      next.bank.set_clock(model_->bank.clock());
  }
  return false;
}

/// Moves the force point to the surface of a new body: to the nearest point, or, if none has been
/// set, to the point nearest to the user, who looks from +z.
void StruckBody::snap_point_to_surface() noexcept {
  const Surface& surface = model_->loaded->surface;
  if (surface.empty()) {
    point_ = {};
    return;
  }
  const Vec3 there =
      point_set_ ? point_.position
                 : 0.5 * (surface.lowest() + surface.highest()) + Vec3{0, 0, surface.diagonal()};
  point_ = surface.nearest(there);
  point_direction_ = point_.normal;
}

/// Continues the direct sound of forces with the new model of the same body.
void StruckBody::continue_direct(Handover* before, const Transition& change) noexcept {
  if (!change.in_silence && have_compatible_kernels(*model_, *before->model))
    return take_over_direct(before, change.gliding);
  if (change.in_silence) {
    direct_.clear();
  } else { // sound on its way goes on to the listeners that stay
    direct_.merge_parts(before->model->bank.glide(0));
    direct_.clear_from(model_->settings.listeners);
  }
  use_current_kernels();
  retire(before);
}

void StruckBody::take_over_contacts(BodyModel& before) noexcept {
  BodyModel& m = *model_;
  const auto take_over_slot = [&](std::size_t slot, std::size_t old_slot, const SurfacePoint& point,
                                  const Vec3& direction, bool held = false) {
    if (!before.solver.contact(old_slot).active)
      return;
    m.gains(point, direction, m.scratch);
    const auto rigid =
        held && !m.recoils(point) ? BodyModel::RigidGain{} : m.rigid_gains(point, direction);
    m.solver.take_over(slot, before.solver, old_slot, m.scratch, rigid);
    m.build_contact_kernels(slot, point, direction);
  };
  begin_resting_contacts();
  const std::size_t voices = before.settings.voices;
  for (std::size_t i = 0; i < std::min(driven_slot(), voices); ++i)
    take_over_slot(i, i, impacts_[i].hit.point, impacts_[i].hit.direction);
  take_over_slot(driven_slot(), voices, point_, point_direction_);
  // The hand moves with the surface and keeps its force, until it lifts.
  const double now = m.solver.contact(driven_slot()).exciter.position_m,
               then = before.solver.contact(voices).exciter.position_m;
  if (now > 0 && then > 0)
    hand_scale_ *= now / then;
  take_over_slot(rub_slot(), voices + 1, rub_.point, -rub_.direction, true);
}

/// Moves scheduled events to the new body, at the same positions in metres.
void StruckBody::move_events(const BodyModel& before) noexcept {
  for (std::size_t i = 0; i < events_.size(); ++i) {
    Hit& hit = events_[i].hit;
    const bool along_normal = hit.direction == hit.point.normal;
    hit.point = model_->nearest(before.settings.size * hit.point.position);
    if (along_normal)
      hit.direction = hit.point.normal;
    Rub& rub = events_[i].rub;
    rub.point = model_->nearest(before.settings.size * rub.point.position);
    rub.direction = along_surface(rub.point.normal, rub.direction);
  }
}

/// Hands a body to the publishing thread for deletion, when its last owner retires it.
void StruckBody::retire(Handover* body) noexcept {
  if (!body || --body->owners > 0)
    return;
  body->next = retired_.load(std::memory_order_relaxed);
  while (!retired_.compare_exchange_weak(body->next, body, std::memory_order_acq_rel)) {
  }
}

StruckBody::FadingBody& StruckBody::fading_slot() noexcept {
  FadingBody* entry = &fading_[0];
  for (FadingBody& other : fading_)
    if (other.body == nullptr || (entry->body != nullptr && other.left < entry->left))
      entry = &other;
  retire(std::exchange(entry->body, nullptr));
  return *entry;
}

/// Lets modes without a successor, which fade out in the old model's bank, sound through the
/// present delay lines.
void StruckBody::fade_unmatched(Handover* before) noexcept {
  FadingBody& entry = fading_slot();
  ++before->owners;
  entry.body = before;
  entry.before_delay = true;
  entry.recordings = {};
  entry.left = ModeBank::kRelease;
}

/// Keeps all points on the same material points of a surface that has another shape.
void StruckBody::map_points_to_new_shape() noexcept {
  const Surface& surface = model_->loaded->surface;
  if (surface.empty())
    return;
  const auto follow = [&](SurfacePoint& point, Vec3* direction) {
    const bool along_normal = direction && *direction == point.normal;
    point = surface.on(point.triangle, point.weight[1], point.weight[2]);
    if (along_normal)
      *direction = point.normal;
  };
  follow(point_, &point_direction_);
  follow(requested_point_, nullptr);
  for (Rub* rub : {&rub_, &requested_rub_})
    if (rub->placed) {
      follow(rub->point, nullptr);
      rub->direction = along_surface(rub->point.normal, rub->direction);
    }
  for (CoupledImpact& impact : impacts_)
    follow(impact.hit.point, &impact.hit.direction);
  for (PulseImpact& impact : pulses_)
    follow(impact.hit.point, &impact.hit.direction);
  for (std::size_t i = 0; i < events_.size(); ++i) {
    follow(events_[i].hit.point, &events_[i].hit.direction);
    follow(events_[i].rub.point, nullptr);
    events_[i].rub.direction = along_surface(events_[i].rub.point.normal, events_[i].rub.direction);
  }
}

/// Lets an exchanged body ring on by itself while it fades out.
void StruckBody::fade_out(Handover* before, bool glides) noexcept {
  if (glides)
    direct_.merge_parts(before->model->bank.glide(0));
  use_current_kernels();
  Recordings recordings = std::exchange(recordings_, {});
  BodyModel* const model = before->model.get();
  const bool sounds = model && model->settings.sample_rate == sample_rate_ &&
                      (silent_samples_ < kSilence || !model->bank.idle());
  if (!sounds) {
    direct_.clear();
    return retire(before);
  }
  FadingBody* const entry = &fading_slot();
  entry->body = before;
  entry->before_delay = false;
  entry->recordings = recordings;
  for (Recording& r : entry->recordings)
    r.released = true;
  std::swap(entry->direct, direct_);
  direct_.clear();
  std::swap(entry->delay, delay_);
  for (DelayLine& line : delay_)
    line.clear();
  model->bank.release();
  const double travel =
      *std::max_element(model->delay_s.begin(), model->delay_s.end()) * sample_rate_;
  entry->left = ModeBank::kRelease +
                static_cast<std::size_t>(std::min(travel, 0.1 * sample_rate_)) +
                2 * DelayLine::kHalf;
}

void StruckBody::add_fading_before_delay(std::size_t frames) noexcept {
  for (FadingBody& body : fading_) {
    if (!body.body || !body.before_delay)
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
        chunk_.output[l][n] += chunk_.released[l][n];
    body.left -= std::min(body.left, frames);
    if (body.left == 0)
      retire(std::exchange(body.body, nullptr));
  }
}

void StruckBody::add_fading(std::size_t listener_count, std::size_t frames) noexcept {
  for (FadingBody& body : fading_) {
    if (!body.body || body.before_delay)
      continue;
    BodyModel& m = *body.body->model;
    std::array<float*, kMaxListeners> out{};
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      out[l] = chunk_.released[l].data();
    m.bank.process({}, out, frames);
    if (m.uses_recordings)
      play_recordings(m, body.recordings, frames, chunk_.released);
    for (std::size_t l = 0; l < m.settings.listeners; ++l)
      body.direct.finish(l, std::span(chunk_.released[l]).first(frames), Glide());
    for (std::size_t l = 0; l < std::min(m.settings.listeners, listener_count); ++l) {
      body.delay[l].run(chunk_.released[l].data(), frames);
      for (std::size_t n = 0; n < frames; ++n)
        chunk_.output[l][n] += chunk_.released[l][n];
    }
    body.left -= std::min(body.left, frames);
    if (body.left == 0)
      retire(std::exchange(body.body, nullptr));
  }
}

} // namespace tactus::modal

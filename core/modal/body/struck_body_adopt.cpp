#include "core/modal/body/struck_body.hpp"

#include <utility>

/// StruckBody: exchange of the present model for a new model.
namespace tactus::modal {

void StruckBody::adopt() noexcept {
  ModelHandover::Use next = handover_.take();
  if (!next)
    return;
  const Transition change = transition_to(next);
  bool unmatched = false; // modes without a successor are left in the old model's bank
  if (change.same_body && !change.in_silence) {
    unmatched = next->continue_from(*model_);
  } else {
    if (model_)
      next->bank.set_clock(model_->bank.clock());
    if (!change.same_body) {
      strikers_.drop_contacts();
      strikers_.pulses().end_all();
    }
  }
  const ModelHandover::Use before = std::exchange(model_, std::move(next));
  if (before) {
    model_->culled = before->culled;
    move_points(*before, change);
  }
  if (unmatched)
    fading_.fade_unmatched(before);
  if (change.in_contact) {
    strikers_.take_over_contacts(*model_, *before);
    hand_.take_over_contact(point_, *model_, *before);
    rub_.take_over_contact(*model_, *before);
  }
  if (!change.same_body)
    fade_out(before, change.gliding);
  output_.set_delays(*model_, options_.doppler, !change.same_body || change.in_silence);
  if (!point_set_ || !change.same_body)
    snap_point_to_surface();
  update_force_point();
  strikers_.continue_on(*model_);
  if (change.same_body)
    direct_.continue_body(*model_, before, change.gliding, change.in_silence);
}

/// Ends the contacts if they cannot continue.
StruckBody::Transition StruckBody::transition_to(const ModelHandover::Use& next) noexcept {
  Transition change;
  change.resolved = next.same_body() && model_ && next->loaded->follows(*model_->loaded);
  change.same_body =
      change.resolved || (next.same_body() && model_ && model_->loaded == next->loaded);
  change.in_contact = change.same_body && model_->in_solver &&
                      next->settings.sample_rate == model_->settings.sample_rate;
  if (!change.in_contact)
    leave_contact();
  change.in_silence = !model_ || (!change.in_contact && output_.silent() && model_->bank.idle());
  change.gliding = model_ && model_->bank.glide(0).moving();
  return change;
}

void StruckBody::move_points(const BodyModel& before, const Transition& change) noexcept {
  if (change.same_body && !change.resolved)
    return;
  const PointMap map(before, *model_, change.same_body);
  schedule_.move_points(map);
  rub_.move_points(map);
  if (!change.same_body)
    return;
  map.move(point_);
  strikers_.move_points(map);
}

/// Lets an exchanged body ring separately while it fades out.
void StruckBody::fade_out(const ModelHandover::Use& before, bool gliding) noexcept {
  direct_.exchange_body(*model_, before.get(), gliding);
  const RecordingVoices recordings = std::exchange(strikers_.recordings(), {});
  if (before && before->settings.sample_rate == sample_rate_ &&
      (!output_.silent() || !before->bank.idle()))
    fading_.fade_out(before, recordings, direct_.sound(), output_.delay_lines());
  else
    direct_.sound().clear();
}

/// Moves the force point to the surface of a new body: to the nearest point, or, if none has been
/// set, to the point nearest to the user, who looks from +z.
void StruckBody::snap_point_to_surface() noexcept {
  const Surface& surface = model_->loaded->surface;
  if (surface.empty()) {
    point_.point = {};
    return;
  }
  const Vec3 there =
      point_set_ ? point_.point.position
                 : 0.5 * (surface.lowest() + surface.highest()) + Vec3{0, 0, surface.diagonal()};
  point_.point = surface.nearest(there);
  point_.direction = point_.point.normal;
}

} // namespace tactus::modal

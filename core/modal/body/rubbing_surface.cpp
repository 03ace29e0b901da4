#include "core/modal/body/rubbing_surface.hpp"

namespace tactus::modal {

void RubbingSurface::set(const Rub& rub, const ForcePoint& force_point, BodyModel* body,
                         DirectMixer& direct) noexcept {
  rub_ = contact_ = rub;
  if (!body || !body->solver.contact(body->rub_slot()).active)
    return;
  body->solver.set_friction(body->rub_slot(), rub.law);
  set_contact(force_point, *body, direct);
}

void RubbingSurface::begin(const ForcePoint& force_point, BodyModel& body,
                           DirectMixer& direct) noexcept {
  body.enter_contact();
  set_contact(force_point, body, direct);
}

/// Begins or moves the contact.
void RubbingSurface::set_contact(const ForcePoint& force_point, BodyModel& body,
                                 DirectMixer& direct) noexcept {
  if (!contact_.placed)
    contact_.point = force_point.point;
  const SurfacePoint& point = contact_.point;
  contact_.direction = along_surface(point.normal, contact_.direction);
  // gains() is for a force against a direction.
  const Vec3 against = -contact_.direction;
  body.gains(point, against, body.scratch);
  // A rubbed body is held: friction moves its modes but not the body as a whole, unless it rests on
  // a board.
  const BodyModel::RigidGain rigid =
      body.recoils(point) ? body.rigid_gains(point, against) : BodyModel::RigidGain{};
  if (body.solver.contact(body.rub_slot()).active)
    body.solver.move_rub(body.rub_slot(), body.scratch, rigid);
  else
    body.solver.begin_rub(body.rub_slot(), contact_.law, body.scratch, rigid, seed_);
  direct.build_contact_kernels(body.rub_slot(), point, against);
}

void RubbingSurface::press(double normal_force_n, double velocity_m_per_s,
                           const ForcePoint& force_point, BodyModel& body,
                           DirectMixer& direct) noexcept {
  if (!(normal_force_n > 0))
    return body.solver.end(body.rub_slot());
  if (!body.solver.contact(body.rub_slot()).active)
    set_contact(force_point, body, direct);
  body.solver.rub(body.rub_slot(), normal_force_n, velocity_m_per_s);
}

void RubbingSurface::move_points(const PointMap& map) noexcept {
  map.move(rub_);
  map.move(contact_);
}

void RubbingSurface::take_over_contact(BodyModel& now, const BodyModel& before) const noexcept {
  now.take_over_contact(now.rub_slot(), before, before.rub_slot(), contact_.point,
                        -contact_.direction, true);
}

} // namespace tactus::modal

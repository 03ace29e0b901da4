#include "core/modal/body/hand.hpp"

namespace tactus::modal {

void Hand::begin(const Striker& striker, const ForcePoint& point, BodyModel& body,
                 DirectMixer& direct) noexcept {
  body.enter_contact();
  scale_ = 1;
  ContactSolver::Strike contact;
  contact.law = body.impact_law(striker, 1, point.point);
  contact.law.compliance_m_per_n = body.residual_compliance(point.point);
  contact.held = true;
  contact.position_m = -last_height_m_;
  for (std::size_t k = 0; k < body.mode.size(); ++k)
    body.scratch[k] = static_cast<double>(body.force_gain[k]);
  body.solver.begin(body.hand_slot(), contact, body.scratch,
                    body.rigid_gains(point.point, point.direction));
  direct.build_contact_kernels(body.hand_slot(), point.point, point.direction);
}

void Hand::press(double height_m, bool driven, const Striker& striker, const ForcePoint& point,
                 BodyModel& body, DirectMixer& direct) noexcept {
  if (driven && height_m < 0 && !body.solver.contact(body.hand_slot()).active)
    begin(striker, point, body, direct);
  if (body.solver.contact(body.hand_slot()).active)
    body.solver.set_held_position(body.hand_slot(), -height_m * scale_);
}

void Hand::lift(double height_m, bool driven, double force_n, BodyModel& body) noexcept {
  last_height_m_ = height_m;
  if (body.solver.contact(body.hand_slot()).active && (!driven || (height_m >= 0 && force_n == 0)))
    body.solver.end(body.hand_slot());
}

void Hand::take_over_contact(const ForcePoint& point, BodyModel& now,
                             const BodyModel& before) noexcept {
  now.take_over_contact(now.hand_slot(), before, before.hand_slot(), point.point, point.direction);
  // The hand moves with the surface and keeps its force until it lifts.
  const double is = now.solver.contact(now.hand_slot()).exciter.position_m,
               was = before.solver.contact(before.hand_slot()).exciter.position_m;
  if (is > 0 && was > 0)
    scale_ *= is / was;
}

} // namespace tactus::modal

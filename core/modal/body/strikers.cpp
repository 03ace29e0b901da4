#include "core/modal/body/strikers.hpp"

#include <cmath>
#include <limits>

namespace tactus::modal {

void Strikers::strike(const Strike& strike, bool coupled, double cull_db, BodyModel& body,
                      DirectMixer& direct) noexcept {
  const std::size_t slot = free_slot(body);
  order_[slot] = ++count_;
  if (body.uses_recordings)
    return recordings_.strike(slot, body, strike.hit.point.position, strike.hit.speed_m_per_s);
  const std::size_t active = body.active_strikes();
  const bool limit_reached =
      active >= kMaxCoupled || (active > 0 && (active + 1) * body.mode.size() > kMaxCoupledWork);
  // A board reacts to coupled contacts only.
  const bool pulse = limit_reached || !(coupled || body.rests());
  const double limit =
      limit_reached ? std::numeric_limits<double>::infinity() : Pulse::kMaxMassRatio;
  if (strike.hit.falls || !pulse || !pulses_.strike(slot, strike, limit, cull_db, body, direct))
    strike_coupled(slot, strike, body, direct);
}

std::size_t Strikers::free_slot(BodyModel& body) noexcept {
  std::size_t oldest = 0;
  for (std::size_t i = 0; i < body.settings.voices; ++i) {
    if (!pulses_.active(i) && !recordings_.active(i) && !body.solver.contact(i).active &&
        !impacts_[i].in_air)
      return i;
    if (order_[i] < order_[oldest])
      oldest = i;
  }
  body.solver.end(oldest);
  impacts_[oldest] = {};
  find_next_landing();
  pulses_.end(oldest);
  recordings_.end(oldest);
  return oldest;
}

void Strikers::strike_coupled(std::size_t slot, const Strike& strike, BodyModel& body,
                              DirectMixer& direct) noexcept {
  const auto& [hit, striker] = strike;
  body.enter_contact();
  impacts_[slot] = {strike, hit.falls};
  ContactSolver::Strike contact;
  contact.law = body.impact_law(striker, hit.speed_m_per_s, hit.point);
  contact.law.compliance_m_per_n = body.residual_compliance(hit.point);
  contact.mass_kg = striker.mass_kg;
  contact.velocity_m_per_s = hit.speed_m_per_s;
  contact.fall_m_per_s2 = hit.falls ? kGravity : 0;
  body.gains(hit.point, hit.direction, body.scratch);
  body.solver.begin(slot, contact, body.scratch, body.rigid_gains(hit.point, hit.direction));
  direct.build_contact_kernels(slot, hit.point, hit.direction);
}

void Strikers::lift_off(const BodyModel& body) noexcept {
  for (std::size_t i = 0; i < body.settings.voices; ++i)
    if (impacts_[i].bounces && !impacts_[i].in_air && !body.solver.contact(i).active)
      lift_off(i, body);
}

void Strikers::lift_off(std::size_t slot, const BodyModel& body) noexcept {
  CoupledImpact& impact = impacts_[slot];
  const ContactSolver::Contact& contact = body.solver.contact(slot);
  // Supports hold the body in place: the striker lands on the surface at rest.
  const double up = -contact.exciter.velocity_m_per_s;
  const double height = std::max(body.solver.height(slot), 0.0);
  const double landing_speed = std::sqrt(up * up + 2 * kGravity * height);
  const double time = (up + landing_speed) / kGravity;
  // A flight shorter than a contact does not count: the striker stays on the body.
  const bool leaves =
      !contact.settled && std::isfinite(time) && landing_speed > 0 &&
      time > contact.exciter.impact.law().duration(contact.exciter.mass_kg, landing_speed);
  impact.bounces = impact.in_air = leaves;
  if (leaves) {
    impact.landing_speed_m_per_s = landing_speed;
    impact.landing =
        now_ + static_cast<std::uint64_t>(std::clamp(time * body.settings.sample_rate, 1.0, 1e12));
  }
  find_next_landing();
}

void Strikers::find_next_landing() noexcept {
  next_landing_ = kNever;
  for (const CoupledImpact& impact : impacts_)
    if (impact.in_air)
      next_landing_ = std::min(next_landing_, impact.landing);
}

void Strikers::land(BodyModel& body, DirectMixer& direct) noexcept {
  for (std::size_t i = 0; i < body.settings.voices; ++i) {
    const CoupledImpact& impact = impacts_[i];
    if (!impact.in_air || impact.landing > now_)
      continue;
    Strike strike = impact.strike;
    strike.hit.speed_m_per_s = impact.landing_speed_m_per_s;
    strike_coupled(i, strike, body, direct);
  }
  find_next_landing();
}

std::size_t Strikers::flights() const noexcept {
  return static_cast<std::size_t>(std::count_if(
      impacts_.begin(), impacts_.end(), [](const CoupledImpact& impact) { return impact.in_air; }));
}

void Strikers::end_contacts() noexcept {
  for (CoupledImpact& impact : impacts_)
    impact.bounces = impact.in_air;
}

void Strikers::drop_contacts() noexcept {
  impacts_ = {};
  next_landing_ = kNever;
}

void Strikers::move_points(const PointMap& map) noexcept {
  for (CoupledImpact& impact : impacts_)
    map.move(impact.strike.hit);
  pulses_.move_points(map);
}

void Strikers::take_over_contacts(BodyModel& now, const BodyModel& before) const noexcept {
  for (std::size_t i = 0; i < std::min(now.settings.voices, before.settings.voices); ++i) {
    const Hit& hit = impacts_[i].strike.hit;
    now.take_over_contact(i, before, i, hit.point, hit.direction);
  }
}

void Strikers::continue_on(BodyModel& body) noexcept {
  for (std::size_t i = body.settings.voices; i < kMaxContacts; ++i)
    impacts_[i] = {};
  find_next_landing();
  pulses_.continue_on(body);
}

} // namespace tactus::modal

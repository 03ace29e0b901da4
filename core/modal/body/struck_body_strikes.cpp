#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

/// StruckBody: scheduled events, coupled strikes and their bounces, pulses, recordings.
namespace tactus::modal {

contact::ImpactLaw StruckBody::law(const Striker& striker, double speed,
                                   const SurfacePoint& point) const noexcept {
  contact::ImpactLaw law{contact::hertz_stiffness(striker.radius_m, striker.youngs_modulus_pa,
                                                  striker.poisson, model_->modulus_at(point),
                                                  model_->poisson_at(point)),
                         1.5, 0};
  if (striker.stiffness > 0) {
    law.stiffness = striker.stiffness;
    law.exponent = striker.exponent;
    law.dissipation_s_per_m = striker.loss_s_per_m;
  }
  if (striker.restitution < 1)
    law.dissipation_s_per_m = contact::dissipation_for(striker.restitution, speed);
  return law;
}

std::size_t StruckBody::free_slot() noexcept {
  const std::size_t voices = model_->settings.voices;
  std::size_t oldest = 0;
  for (std::size_t i = 0; i < voices; ++i) {
    if (!pulses_[i].active && !recordings_[i].active && !model_->solver.contact(i).active &&
        !impacts_[i].in_air)
      return i;
    if (strike_order_[i] < strike_order_[oldest])
      oldest = i;
  }
  model_->solver.end(oldest);
  impacts_[oldest] = {};
  find_next_landing();
  pulses_[oldest].active = recordings_[oldest].active = false;
  return oldest;
}

bool StruckBody::hit(const Hit& hit) noexcept { return strike(hit, striker_); }

void StruckBody::schedule_hit(const Hit& hit, std::int64_t sample) noexcept {
  schedule({Event::Kind::kHit, hit, striker_, {}}, sample);
}

void StruckBody::schedule_point(const SurfacePoint& point, const Vec3& direction,
                                std::int64_t sample) noexcept {
  requested_point_ = point;
  schedule({Event::Kind::kPoint, {point, direction}, {}, {}}, sample);
}

void StruckBody::schedule_rub(const Rub& rub, std::int64_t sample) noexcept {
  requested_rub_ = rub;
  schedule({Event::Kind::kRub, {}, {}, rub}, sample);
}

void StruckBody::schedule_reset(std::int64_t sample) noexcept {
  schedule({Event::Kind::kReset, {}, {}, {}}, sample);
}

void StruckBody::schedule(const Event& event, std::int64_t sample) noexcept {
  if (events_.full())
    apply_event(events_.pop());
  events_.push(sample, event);
}

/// Applies the events that are due. On a large body strikes are delayed to stay within
/// kMaxStartingWork, and new points to one within kBudgetSamples.
void StruckBody::apply_due_events() noexcept {
  if (clock_ - budget_begin_ >= kBudgetSamples || clock_ < budget_begin_) {
    budget_begin_ = clock_;
    starting_work_ = 0;
  }
  const std::size_t modes = model_ ? model_->mode.size() : 0;
  const std::size_t work = modes + (model_ ? modes * model_->settings.listeners / 4 : 0);
  while (events_.next() <= clock_) {
    const Event event = events_.pop();
    if (event.kind == Event::Kind::kHit) {
      if (starting_work_ > 0 && starting_work_ + work > kMaxStartingWork) {
        events_.push(budget_begin_ + kBudgetSamples, event);
        continue;
      }
      starting_work_ += work;
    } else if (event.kind != Event::Kind::kReset && modes > kMaxUnthrottledModes) {
      std::int64_t& moved = event.kind == Event::Kind::kPoint ? point_moved_ : rub_moved_;
      const std::int64_t free_at = moved + kBudgetSamples;
      if (clock_ < free_at && clock_ >= moved) {
        if (!has_event_by(event.kind, free_at)) // else a newer one replaces it
          events_.push(free_at, event);
        continue;
      }
      moved = clock_;
    }
    apply_event(event);
  }
}

bool StruckBody::has_event_by(Event::Kind kind, std::int64_t sample) noexcept {
  for (std::size_t i = 0; i < events_.size() && events_.time(i) <= sample; ++i)
    if (events_[i].kind == kind)
      return true;
  return false;
}

void StruckBody::apply_event(const Event& event) noexcept {
  switch (event.kind) {
  case Event::Kind::kHit:
    strike(event.hit, event.striker);
    break;
  case Event::Kind::kPoint: {
    const SurfacePoint requested = requested_point_;
    set_point(event.hit.point, event.hit.direction);
    requested_point_ = requested; // a later point may be scheduled
    break;
  }
  case Event::Kind::kRub:
    set_rub(event.rub);
    break;
  case Event::Kind::kReset:
    reset();
    break;
  }
}

bool StruckBody::strike(const Hit& hit, const Striker& striker) noexcept {
  if (!model_ || !(hit.speed_m_per_s > 0))
    return false;
  const std::size_t slot = free_slot();
  strike_order_[slot] = ++strike_count_;
  if (model_->uses_recordings)
    strike_recording(slot, hit);
  else {
    const std::size_t active = active_strikes();
    const bool limit_reached = active >= kMaxCoupled ||
                               (active > 0 && (active + 1) * model_->mode.size() > kMaxCoupledWork);
    // A board reacts to coupled contacts only.
    const bool pulse = limit_reached || !(options_.coupled || has_resting_contacts());
    const double limit =
        limit_reached ? std::numeric_limits<double>::infinity() : Pulse::kMaxMassRatio;
    if (hit.falls || !pulse || !strike_pulse(slot, hit, striker, limit))
      strike_coupled(slot, hit, striker);
  }
  return true;
}

void StruckBody::strike_coupled(std::size_t slot, const Hit& hit, const Striker& striker) noexcept {
  enter_contact();
  impacts_[slot] = {hit, striker, hit.falls, false, 0, 0};
  ContactSolver::Strike strike;
  strike.law = law(striker, hit.speed_m_per_s, hit.point);
  strike.law.compliance_m_per_n = model_->residual_compliance(hit.point);
  strike.mass_kg = striker.mass_kg;
  strike.velocity_m_per_s = hit.speed_m_per_s;
  strike.fall_m_per_s2 = hit.falls ? kGravity : 0;
  model_->gains(hit.point, hit.direction, model_->scratch);
  model_->solver.begin(slot, strike, model_->scratch,
                       model_->rigid_gains(hit.point, hit.direction));
  build_contact_kernels(slot, hit.point, hit.direction);
}

/// Contacts have ended: falling strikers are in the air, unless they lie still.
void StruckBody::start_flights() noexcept {
  for (std::size_t i = 0; i < model_->settings.voices; ++i)
    if (impacts_[i].bounces && !impacts_[i].in_air && !model_->solver.contact(i).active)
      start_flight(i);
}

void StruckBody::start_flight(std::size_t slot) noexcept {
  CoupledImpact& impact = impacts_[slot];
  const ContactSolver::Contact& contact = model_->solver.contact(slot);
  // Supports hold the body in place: the striker lands on the surface at rest.
  const double up = -contact.exciter.velocity_m_per_s;
  const double height = std::max(model_->solver.height(slot), 0.0);
  const double landing_speed = std::sqrt(up * up + 2 * kGravity * height);
  const double time = (up + landing_speed) / kGravity;
  // A flight shorter than a contact is none: the striker stays.
  const bool leaves =
      !contact.settled && std::isfinite(time) && landing_speed > 0 &&
      time > contact.exciter.impact.law().duration(contact.exciter.mass_kg, landing_speed);
  impact.bounces = impact.in_air = leaves;
  if (leaves) {
    impact.landing_speed_m_per_s = landing_speed;
    impact.landing = now_ + static_cast<std::uint64_t>(std::clamp(time * sample_rate_, 1.0, 1e12));
  }
  find_next_landing();
}

void StruckBody::find_next_landing() noexcept {
  next_landing_ = kNever;
  for (const CoupledImpact& impact : impacts_)
    if (impact.in_air)
      next_landing_ = std::min(next_landing_, impact.landing);
}

void StruckBody::begin_landed_contacts() noexcept {
  for (std::size_t i = 0; i < model_->settings.voices; ++i) {
    const CoupledImpact impact = impacts_[i];
    if (!impact.in_air || impact.landing > now_)
      continue;
    Hit hit = impact.hit;
    hit.speed_m_per_s = impact.landing_speed_m_per_s;
    strike_coupled(i, hit, impact.striker);
  }
  find_next_landing();
}

/// False if the striker is too heavy for a single pulse (Pulse::mass_ratio).
bool StruckBody::strike_pulse(std::size_t slot, const Hit& hit, const Striker& striker,
                              double max_mass_ratio) noexcept {
  std::vector<double>& gain = model_->scratch;
  model_->gains(hit.point, hit.direction, gain);
  double rigid = 0;
  for (const double b : model_->rigid_gains(hit.point, hit.direction))
    rigid += b * b;
  const Pulse pulse =
      find_pulse(law(striker, hit.speed_m_per_s, hit.point), striker.mass_kg, hit.speed_m_per_s,
                 striker.restitution,
                 {gain, model_->rate, rigid, model_->residual_compliance(hit.point), model_->band});
  if (pulse.mass_ratio > max_mass_ratio)
    return false;
  pulses_[slot] = {hit, pulse, 0, true};
  // Modes quieter than the loudest by cull_db are left out.
  double loudest = 0;
  std::array<double, kPulseBands> envelope{}; // at each band's lowest frequency
  for (std::size_t i = 0; i < kPulseBands; ++i)
    envelope[i] = Pulse::envelope(pulse_band_begin(i) * pulse.duration_s);
  std::vector<double>& level = model_->scratch_level;
  for (std::size_t k = 0; k < model_->audible_modes; ++k) {
    level[k] = std::abs(gain[k]) * envelope[model_->band[k]] * model_->loudness[k];
    loudest = std::max(loudest, level[k]);
  }
  const double minimum = loudest * std::pow(10, -options_.cull_db / 20);
  culled_ = 0;
  for (std::size_t k = 0; k < model_->audible_modes; ++k)
    if (level[k] < minimum) {
      gain[k] = 0;
      ++culled_;
    }
  set_pulse_gains(slot, gain);
  build_pulse_kernels(slot, hit.point, hit.direction);
  return true;
}

void StruckBody::set_pulse_gains(std::size_t slot, std::span<double> gain) noexcept {
  BodyModel& m = *model_;
  for (std::size_t k = 0; k < gain.size(); ++k)
    gain[k] *= m.pulse_gain[k];
  m.bank.set_gain(1 + slot, std::span<const double>(gain).first(m.audible_modes));
}

/// Continues the present pulses on a new model of the body.
void StruckBody::continue_pulses() noexcept {
  BodyModel& m = *model_;
  for (std::size_t i = 0; i < pulses_.size(); ++i) {
    PulseImpact& pulse = pulses_[i];
    pulse.active = pulse.active && i < m.settings.voices;
    if (!pulse.active)
      continue;
    m.gains(pulse.hit.point, pulse.hit.direction, m.scratch);
    set_pulse_gains(i, m.scratch);
    m.build_pulse_kernels(i, pulse.hit.point, pulse.hit.direction, m.scratch);
  }
}

void StruckBody::strike_recording(std::size_t slot, const Hit& hit) noexcept {
  const RawTable& table = model_->loaded->table.raw;
  std::size_t nearest = 0;
  double minimum = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < table.hits; ++i)
    if (const double distance = norm(table.hit_m[i] - hit.point.position); distance < minimum) {
      minimum = distance;
      nearest = i;
    }
  recordings_[slot] = {nearest, hit.speed_m_per_s, 0, true};
}

void StruckBody::play_recordings(const BodyModel& model, Recordings& recordings, std::size_t frames,
                                 ChannelBlock& output) noexcept {
  const RawTable& table = model.loaded->table.raw;
  for (Recording& r : recordings) {
    if (!r.active)
      continue;
    for (std::size_t n = 0; n < frames && r.release_left > 0; ++n) {
      double level = r.speed_m_per_s;
      if (r.released)
        level *= ModeBank::release_share(r.release_left--);
      for (std::size_t l = 0; l < model.settings.listeners; ++l)
        output[l][n] += static_cast<float>(level * model.raw[l].pressure(table, r.hit, r.age_s));
      r.age_s += 1 / sample_rate_;
    }
    r.active = r.release_left > 0 && r.age_s < model.raw[0].end_s(table);
  }
}

void StruckBody::make_pulses(std::size_t frames) noexcept {
  if (!model_)
    return;
  for (std::size_t i = 0; i < model_->settings.voices; ++i) {
    PulseImpact& impact = pulses_[i];
    if (!impact.active)
      continue;
    // Each sample holds the mean force of its interval, so that the impulse is exact.
    const auto passed = [&](double t) {
      return 0.5 * (1 - std::cos(std::numbers::pi * std::min(t / impact.pulse.duration_s, 1.0)));
    };
    for (std::size_t n = 0; n < frames; ++n) {
      const double next = impact.age_s + 1 / sample_rate_;
      chunk_.pulse[i][n] = static_cast<float>(impact.pulse.impulse_n_s * sample_rate_ *
                                              (passed(next) - passed(impact.age_s)));
      impact.age_s = next;
      chunk_.contact[n] += chunk_.pulse[i][n];
    }
  }
}

} // namespace tactus::modal

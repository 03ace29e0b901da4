#include "core/contact/excited_body.hpp"

#include <cmath>
#include <vector>

/// Single contacts: each is alone in its island, on at most kFewModes modes. The code is scalar and
/// keeps all values in registers.
namespace tactus::contact {
namespace {

/// Computes the step's force and mean approach velocity; the force is 0 if the contact does not
/// act.
void solve_single_force(ContactTerm& t, double mobility) noexcept {
  t.force = 0;
  t.mean = t.free;
  t.acts = t.law.slope_ns_per_m > ContactSystem::kMinSlope;
  if (!t.acts)
    return;
  t.solve(mobility);
  if (t.force < 0 && !t.may_be_negative) {
    t.acts = false;
    t.force = 0;
    t.mean = t.free;
  }
}

} // namespace

/// State of one mode of a single contact, and its shape at the contact point.
struct ExcitedBody::SingleMode {
  double shape, real, imaginary;
};

/// Advances an impact in contact on one mode by a sample, in one step and without compliance. The
/// result has the bits of step_single() and takes fewer instructions. For other contacts it returns
/// false and does nothing.
bool ExcitedBody::step_single_impact(std::size_t slot) noexcept {
  Exciter& e = exciters_[slot];
  const FewModes& few = few_[slot];
  if (few.count != 1 || !e.impact.touching() || e.impact.compliant() || !(e.depth_m > 0))
    return false;
  const ModalBody::Level& level = body_.level(0);
  const double h = step_s_[0];
  const std::uint32_t i = few.mode[0];
  const double shape = few.shape[0], real = from_real_[i], imaginary = from_imaginary_[i];
  const double body_free =
      shape * (level.mean_real[i] * real + level.mean_imaginary[i] * imaginary);
  const double cosine = level.pole_real[i], sine = level.pole_imaginary[i];
  const double response_real = level.response_real[i],
               response_imaginary = level.response_imaginary[i];
  const double x = e.depth_m, velocity = e.velocity_m_per_s,
               own_mobility = 0.5 * h * e.inverse_mass, mobility = e.mobility[0],
               mean_before = e.mean_velocity_m_per_s;
  const double own_free_velocity = velocity + own_mobility * e.external_force_n,
               free = own_free_velocity - body_free;
  const LinearForce law = e.impact.enter_step<false>(x, e.approach_m_per_s, h);
  const double inverse_denominator = 1 / (1 + mobility * law.slope_ns_per_m);
  double force = (law.offset_n + law.slope_ns_per_m * free) * inverse_denominator, mean = free;
  if (law.slope_ns_per_m > ContactSystem::kMinSlope && !(force < 0)) {
    mean = (free - mobility * law.offset_n) * inverse_denominator;
    e.impact.pass_step(mean, h);
  } else {
    force = 0;
  }
  const double own_mean_velocity = own_free_velocity - own_mobility * force, after = x + h * mean;
  e.impact.leave_step<false>(after);
  e.position_m += h * own_mean_velocity;
  e.velocity_m_per_s = 2 * own_mean_velocity - velocity;
  e.depth_m = after;
  e.approach_m_per_s = extrapolate_velocity(mean, mean_before);
  e.mean_velocity_m_per_s = mean;
  e.impulse_ns = h * force;
  e.force_n = e.impulse_ns * body_.sample_rate();
  e.record_step(x, after, force, h);
  const double modal_force = shape * force;
  body_.real[i] = cosine * real - sine * imaginary + response_real * modal_force;
  body_.imaginary[i] = cosine * imaginary + sine * real + response_imaginary * modal_force;
  return true;
}

/// Gives a contact too short for steps an impulse with the restitution of its law (see
/// solve_impulses()).
void ExcitedBody::solve_single_impulse(Exciter& e, std::span<const std::uint32_t> modes,
                                       SingleMode* state, double h) const noexcept {
  double rate = e.velocity_m_per_s;
  for (std::size_t k = 0; k < modes.size(); ++k)
    rate -=
        state[k].shape * (state[k].real - body_.decay_over_omega[modes[k]] * state[k].imaginary);
  e.approach_m_per_s = rate;
  if (!(rate > 0) || !Impact::in_contact(e.depth_m, rate, h))
    return;
  const double restitution_coefficient = restitution(e.impact.law().dissipation_s_per_m * rate);
  const double impulse = (1 + restitution_coefficient) * rate * e.effective_mass_kg;
  for (std::size_t k = 0; k < modes.size(); ++k)
    state[k].real += impulse * state[k].shape;
  e.velocity_m_per_s -= impulse * e.inverse_mass;
  e.impulse_ns += impulse;
  e.record_impulse(impulse, h);
  e.approach_m_per_s = e.mean_velocity_m_per_s = -restitution_coefficient * rate;
}

/// Advances a single contact by a sample.
void ExcitedBody::step_single(std::size_t slot, std::size_t level_index) noexcept {
  Exciter& e = exciters_[slot];
  const ModalBody::Level& level = body_.level(level_index);
  const double h = step_s_[level_index];
  const FewModes& few = few_[slot];
  const std::span<const std::uint32_t> modes{few.mode.data(), few.count};
  std::array<SingleMode, kFewModes> state;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const std::uint32_t i = modes[k];
    state[k] = {few.shape[k], from_real_[i], from_imaginary_[i]};
  }
  ContactTerm t;
  const bool strikes = e.kind == Exciter::Kind::kImpact;
  const double own_mobility = strikes ? 0.5 * h * e.inverse_mass : 0;
  const double mobility = e.mobility[level_index];
  for (std::size_t n = std::size_t{1} << level_index; n-- > 0;) {
    if (strikes && e.impulsive && !e.impact.touching())
      solve_single_impulse(e, modes, state.data(), h);
    double body_free = 0;
    for (std::size_t k = 0; k < modes.size(); ++k)
      body_free += state[k].shape * (level.mean_real[modes[k]] * state[k].real +
                                     level.mean_imaginary[modes[k]] * state[k].imaginary);
    e.enter_step(t, body_free, mobility - own_mobility, h);
    solve_single_force(t, mobility);
    if (e.kind == Exciter::Kind::kFriction) {
      e.refine(t);
      solve_single_force(t, mobility);
    }
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const std::uint32_t i = modes[k];
      SingleMode& z = state[k];
      const double force = z.shape * t.force, real = z.real;
      z.real = level.pole_real[i] * real - level.pole_imaginary[i] * z.imaginary +
               level.response_real[i] * force;
      z.imaginary = level.pole_real[i] * z.imaginary + level.pole_imaginary[i] * real +
                    level.response_imaginary[i] * force;
    }
    e.leave_step(t, h);
  }
  e.force_n = e.impulse_ns * body_.sample_rate();
  for (std::size_t k = 0; k < modes.size(); ++k) {
    body_.real[modes[k]] = state[k].real;
    body_.imaginary[modes[k]] = state[k].imaginary;
  }
}

/// Returns a contact in pressed_ to the single contacts that step_single() advances.
void ExcitedBody::release_pressed(std::size_t slot) noexcept {
  pressed_.remove(slot, exciters_[slot], step_s_[0]);
  single_awake_.push_back(slot);
}

void ExcitedBody::update_pressed(bool measure) noexcept {
  kernel_->check_pressed(pressed_.blocks(), body_.real.data(), body_.imaginary.data(), measure,
                         step_s_[0]);
  pressed_.for_each_marked([this](std::size_t slot) { release_pressed(slot); });
}

/// Advances the contacts in pressed_ by a sample, and records those that end in it.
void ExcitedBody::step_pressed() noexcept {
  if (pressed_.empty())
    return;
  kernel_->press(pressed_.blocks(), from_real_, from_imaginary_, body_.real.data(),
                 body_.imaginary.data(), body_.sample_rate());
  pressed_.for_each_marked([&](std::size_t slot) {
    const PressedContacts::Step step = pressed_.last_step(slot);
    release_pressed(slot);
    single_near_.push_back(slot);
    Exciter& e = exciters_[slot];
    if (e.depth_m > 0)
      return;
    e.impact.leave_step<false>(e.depth_m);
    e.record_step(step.before_m, e.depth_m, step.force_n, step_s_[0]);
  });
}

/// Moves sustained single contacts on one mode into pressed_.
void ExcitedBody::gather_pressed() noexcept {
  if (min_level_ > 0 || single_near_.empty())
    return;
  bool any = false;
  for (const std::size_t i : single_near_) {
    const Exciter& e = exciters_[i];
    const FewModes& few = few_[i];
    if (e.kind != Exciter::Kind::kImpact || few.count != 1 || e.level > 0 || e.impulsive ||
        !e.depth_valid || !e.impact.touching() || e.impact.compliant() || !(e.depth_m > 0) ||
        pressed_.holds(i))
      continue;
    const ModalBody::Level& level = body_.level(0);
    const std::uint32_t k = few.mode[0];
    pressed_.add(i, e,
                 {k, few.shape[0], level.pole_real[k], level.pole_imaginary[k],
                  level.response_real[k], level.response_imaginary[k], level.mean_real[k],
                  level.mean_imaginary[k], body_.displacement[k], body_.decay_over_omega[k]},
                 step_s_[0]);
    any = true;
  }
  if (any)
    std::erase_if(single_awake_, [this](std::size_t i) { return pressed_.holds(i); });
}

} // namespace tactus::contact

#include "core/contact/touched_body.hpp"

#include <cmath>
#include <vector>

/// Contacts that are alone on a few modes: without vectors, all in registers.
namespace tactus::contact {

/// The step of an impact under way on one mode, where a sample is one step and the law does not
/// yield: touch_lone() in fewer instructions, to the same bits.
bool TouchedBody::press_lone(std::size_t slot) noexcept {
  Exciter& e = exciters_[slot];
  const FewModes& few = few_[slot];
  if (few.count != 1 || has_outer_ || !e.impact.touching() || e.impact.yields() || !(e.depth_m > 0))
    return false;
  const ModalBody::Level& level = body_.level(0);
  const double h = step_s_[0];
  const std::uint32_t i = few.mode[0];
  const double shape = few.shape[0], real = from_real_[i], imaginary = from_imaginary_[i];
  const double body_free =
      shape * (level.mean_real[i] * real + level.mean_imaginary[i] * imaginary);
  const double cosine = level.turn_real[i], sine = level.turn_imaginary[i];
  const double response_real = level.response_real[i],
               response_imaginary = level.response_imaginary[i];
  const double x = e.depth_m, velocity = e.velocity_m_per_s, own = 0.5 * h * e.per_mass,
               mobility = e.mobility[0], mean_before = e.mean_velocity_m_per_s;
  const double own_free = velocity + own * e.outer_force_n, free = own_free - body_free;
  const LinearForce law = e.impact.enter_step<false>(x, e.approach_m_per_s, h);
  const double under = 1 / (1 + mobility * law.slope_ns_per_m);
  double force = (law.offset_n + law.slope_ns_per_m * free) * under, mean = free;
  if (law.slope_ns_per_m > ContactSystem::kLeastSlope && !(force < 0)) {
    mean = (free - mobility * law.offset_n) * under;
    e.impact.pass_step(mean, h);
  } else {
    force = 0;
  }
  const double own_mean = own_free - own * force, after = x + h * mean;
  e.impact.leave_step<false>(after);
  e.place_m += h * own_mean;
  e.velocity_m_per_s = 2 * own_mean - velocity;
  e.depth_m = after;
  e.approach_m_per_s = continued(mean, mean_before);
  e.mean_velocity_m_per_s = mean;
  e.impulse_ns = h * force;
  e.force_n = e.impulse_ns * body_.sample_rate();
  e.book(x, after, force, h);
  const double push = shape * force;
  body_.real[i] = cosine * real - sine * imaginary + response_real * push;
  body_.imaginary[i] = cosine * imaginary + sine * real + response_imaginary * push;
  return true;
}

/// A sample of one contact alone on a few modes.
void TouchedBody::touch_lone(std::size_t slot, std::size_t level_index) noexcept {
  Exciter& e = exciters_[slot];
  const ModalBody::Level& level = body_.level(level_index);
  const double h = step_s_[level_index];
  const FewModes& few = few_[slot];
  const std::span<const std::uint32_t> modes{few.mode.data(), few.count};
  struct LoneMode {
    double shape, real, imaginary, outer;
  };
  std::array<LoneMode, kFewModes> state;
  double outer_mean = 0;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const std::uint32_t i = modes[k];
    state[k] = {few.shape[k], from_real_[i], from_imaginary_[i], has_outer_ ? outer_[i] : 0.0};
    outer_mean += state[k].shape * level.mobility[i] * state[k].outer;
  }
  ContactTerm t;
  const bool strikes = e.kind == Exciter::Kind::kImpact;
  const double own = strikes ? 0.5 * h * e.per_mass : 0;
  const double mobility = e.mobility[level_index];
  for (std::size_t n = std::size_t{1} << level_index; n-- > 0;) {
    if (strikes && e.impulsive && !e.impact.touching()) { // as in knock_many()
      double rate = e.velocity_m_per_s;
      for (std::size_t k = 0; k < modes.size(); ++k)
        rate -= state[k].shape * (state[k].real - body_.slowing[modes[k]] * state[k].imaginary);
      e.approach_m_per_s = rate;
      if (rate > 0 && Impact::meets(e.depth_m, rate, h)) {
        const double kept = restitution(e.impact.law().dissipation_s_per_m * rate);
        const double impulse = (1 + kept) * rate * e.effective_mass_kg;
        for (std::size_t k = 0; k < modes.size(); ++k)
          state[k].real += impulse * state[k].shape;
        e.velocity_m_per_s -= impulse * e.per_mass;
        e.impulse_ns += impulse;
        e.book_impulse(impulse, h);
        e.approach_m_per_s = e.mean_velocity_m_per_s = -kept * rate;
      }
    }
    double body_free = outer_mean;
    for (std::size_t k = 0; k < modes.size(); ++k)
      body_free += state[k].shape * (level.mean_real[modes[k]] * state[k].real +
                                     level.mean_imaginary[modes[k]] * state[k].imaginary);
    e.enter_step(t, body_free, mobility - own, h);
    const auto solve = [&] {
      t.force = 0;
      t.mean = t.free;
      t.acts = t.law.slope_ns_per_m > ContactSystem::kLeastSlope;
      if (!t.acts)
        return;
      t.solve(mobility);
      if (t.force < 0 && !t.may_pull) {
        t.acts = false;
        t.force = 0;
        t.mean = t.free;
      }
    };
    solve();
    if (e.kind == Exciter::Kind::kFriction) {
      e.refine(t);
      solve();
    }
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const std::uint32_t i = modes[k];
      LoneMode& z = state[k];
      const double force = z.outer + z.shape * t.force, real = z.real;
      z.real = level.turn_real[i] * real - level.turn_imaginary[i] * z.imaginary +
               level.response_real[i] * force;
      z.imaginary = level.turn_real[i] * z.imaginary + level.turn_imaginary[i] * real +
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

/// A contact in pressed_ goes on the general way.
void TouchedBody::let_go(std::size_t slot) noexcept {
  pressed_.remove(slot, exciters_[slot], step_s_[0]);
  lone_awake_.push_back(slot);
}

void TouchedBody::look_at_pressed(bool look) noexcept {
  kernel_->look_at(pressed_.blocks(), body_.real.data(), body_.imaginary.data(), look, step_s_[0]);
  pressed_.for_each_marked([this](std::size_t slot) { let_go(slot); });
}

/// A sample of the contacts in pressed_.
void TouchedBody::touch_pressed() noexcept {
  if (pressed_.empty())
    return;
  kernel_->press(pressed_.blocks(), from_real_, from_imaginary_, body_.real.data(),
                 body_.imaginary.data(), body_.sample_rate());
  pressed_.for_each_marked([&](std::size_t slot) {
    const PressedContacts::Step step = pressed_.last_step(slot);
    let_go(slot);
    lone_near_.push_back(slot);
    Exciter& e = exciters_[slot];
    if (e.depth_m > 0)
      return;
    e.impact.leave_step<false>(e.depth_m);
    e.book(step.before_m, e.depth_m, step.force_n, step_s_[0]);
  });
}

/// Lone contacts under way that go on quietly are gathered into pressed_.
void TouchedBody::gather_pressed() noexcept {
  if (has_outer_ || least_level_ > 0 || lone_near_.empty())
    return;
  bool any = false;
  for (const std::size_t i : lone_near_) {
    const Exciter& e = exciters_[i];
    const FewModes& few = few_[i];
    if (e.kind != Exciter::Kind::kImpact || few.count != 1 || e.level > 0 || e.impulsive ||
        !e.fresh || !e.impact.touching() || e.impact.yields() || !(e.depth_m > 0) ||
        pressed_.holds(i))
      continue;
    const ModalBody::Level& level = body_.level(0);
    const std::uint32_t k = few.mode[0];
    pressed_.add(i, e,
                 {k, few.shape[0], level.turn_real[k], level.turn_imaginary[k],
                  level.response_real[k], level.response_imaginary[k], level.mean_real[k],
                  level.mean_imaginary[k], body_.displacement[k], body_.slowing[k]},
                 step_s_[0]);
    any = true;
  }
  if (any)
    std::erase_if(lone_awake_, [this](std::size_t i) { return pressed_.holds(i); });
}

} // namespace tactus::contact

#include "core/contact/excited_body.hpp"

#include <algorithm>
#include <cmath>

/// The steps of several contacts that are solved together.
namespace tactus::contact {
namespace {

constexpr int kImpulseIterations = 8;

} // namespace

/// Mobility matrix Y of a group's contacts.
void ExcitedBody::couple(const Group& group) noexcept {
  const std::size_t count = group.slots.size();
  system_.clear_coupling(count);
  for (std::size_t c = 0; c < count; ++c)
    for (std::size_t d = 0; d <= c; ++d)
      system_.coupling(d, c) = system_.coupling(c, d) =
          kernel_->dot(shapes_[c], shapes_[d], group.modes.mobility, group.modes.padded);
}

void ExcitedBody::step_coupled(const Group& group) noexcept {
  const double h = step_s_[group.level];
  const ModesView& modes = group.modes;
  const std::span<const std::size_t> slots = group.slots;
  const std::size_t count = slots.size();
  for (std::size_t n = std::size_t{1} << group.level; n-- > 0;) {
    solve_impulses(group);
    kernel_->free_mean(modes, mean_.data());
    bool any_friction = false;
    for (std::size_t c = 0; c < count; ++c) {
      Exciter& e = exciters_[slots[c]];
      e.enter_step(system_[c], kernel_->dot(shapes_[c], mean_.data(), modes.padded),
                   system_.coupling(c, c), h);
      any_friction = any_friction || e.kind == Exciter::Kind::kFriction;
    }
    solve(group);
    if (any_friction) {
      for (std::size_t c = 0; c < count; ++c)
        if (Exciter& e = exciters_[slots[c]]; e.kind == Exciter::Kind::kFriction)
          e.refine(system_[c]);
      solve(group);
    }
    forces_.clear();
    for (const std::size_t c : system_.acting())
      forces_.push_back({shapes_[c], system_[c].force});
    if (forces_.size() < count) // some contacts have no force: find their velocities
      kernel_->mean(modes, forces_, mean_.data());
    kernel_->advance(modes, forces_);
    for (std::size_t c = 0; c < count; ++c) {
      ContactTerm& t = system_[c];
      if (!t.acts) {
        t.force = 0;
        t.mean = t.own_free_velocity - kernel_->dot(shapes_[c], mean_.data(), modes.padded);
      }
      exciters_[slots[c]].leave_step(t, h);
    }
  }
  for (const std::size_t i : slots)
    exciters_[i].force_n = exciters_[i].impulse_ns * body_.sample_rate();
}

void ExcitedBody::solve(const Group& group) noexcept {
  system_.solve(group.slots.size(), [&](std::span<const std::size_t> acting) {
    const bool by_mode = acting.size() > group.mode_count;
    if (by_mode)
      solve_by_mode(group, acting);
    return by_mode;
  });
}

/// Solution for more contacts than modes. The unknowns are the changes d of the modes' mean
/// velocities. Each contact's force is eliminated: with its shape g and the exciter's mobility y_e,
///     F = (offset + slope (free - g.d))/(1 + slope y_e).
/// With the modes' mobilities y this leaves
///     d/y + sum g (g.d) slope/(1 + slope y_e) = sum g (offset + slope free)/(1 + slope y_e).
void ExcitedBody::solve_by_mode(const Group& group, std::span<const std::size_t> acting) noexcept {
  const std::size_t count = group.mode_count, stride = group.modes.padded;
  const double* const mobility = group.modes.mobility;
  const DenseView matrix{matrix_.data(), count, stride};
  std::fill_n(matrix_.data(), count * stride, 0.0);
  std::fill_n(right_.data(), stride, 0.0);
  std::fill_n(other_.data(), stride, 0.0);
  for (std::size_t i = 0; i < count; ++i)
    matrix(i, i) = mobility[i] > 0 ? 1 / mobility[i] : 1;
  for (const std::size_t c : acting) {
    const ContactTerm& t = system_[c];
    const double* shape = shapes_[c];
    const double inverse_denominator = 1 / (1 + t.law.slope_ns_per_m * t.own_mobility);
    kernel_->add(right_.data(), shape,
                 inverse_denominator * (t.law.offset_n + t.law.slope_ns_per_m * t.free), stride);
    system_.dense().add_square(matrix, shape, inverse_denominator * t.law.slope_ns_per_m);
  }
  system_.dense().factorise(matrix, 1e-300);
  system_.dense().substitute(matrix, right_.data(), other_.data());
  for (const std::size_t c : acting) {
    ContactTerm& t = system_[c];
    const double change = kernel_->dot(shapes_[c], right_.data(), stride);
    const double inverse_denominator = 1 / (1 + t.law.slope_ns_per_m * t.own_mobility);
    t.force = inverse_denominator * (t.law.offset_n + t.law.slope_ns_per_m * (t.free - change));
    t.mean = inverse_denominator * (t.free - change - t.own_mobility * t.law.offset_n);
  }
}

/// Simultaneous contacts that are too short for steps. Alone, each would have the impulse J = (1 +
/// e) v/A, v its rate of approach, A its mobility for impulses. Together they have theta J with
/// theta = min(1, (1 + e_min) J.v/(J.A J)): the energy then changes by dE = -theta J.v + theta^2
/// J.A J/2 <= 0. This is repeated while contacts still approach.
void ExcitedBody::solve_impulses(const Group& group) noexcept {
  const double h = step_s_[group.level];
  const ModesView& m = group.modes;
  const std::size_t padded = m.padded, count = group.slots.size();
  const auto velocity_at = [&](std::size_t c) {
    return kernel_->velocity(shapes_[c], m.real, m.imaginary, m.decay_over_omega, padded);
  };
  for (std::size_t c = 0; c < count; ++c) { // current velocity of approach
    Exciter& e = exciters_[group.slots[c]];
    if (e.kind == Exciter::Kind::kImpact && e.impulsive && !e.impact.touching())
      e.approach_m_per_s = e.velocity_m_per_s - velocity_at(c);
  }
  for (int iteration = 0; iteration < kImpulseIterations; ++iteration) {
    double work = 0, mass_term = 0, min_restitution = 1; // work: J.v; mass_term: sum of J^2/mass
    std::fill_n(mean_.data(), padded, 0.0);
    bool any = false;
    for (std::size_t c = 0; c < count; ++c) {
      const Exciter& e = exciters_[group.slots[c]];
      ContactTerm& t = system_[c];
      t.acts = e.kind == Exciter::Kind::kImpact && e.impulsive && !e.impact.touching() &&
               e.approach_m_per_s > 0 && Impact::in_contact(e.depth_m, e.approach_m_per_s, h);
      if (!t.acts)
        continue;
      const double restitution_coefficient =
          restitution(e.impact.law().dissipation_s_per_m * e.approach_m_per_s);
      t.force = (1 + restitution_coefficient) * e.approach_m_per_s / e.impulse_mobility;
      work += t.force * e.approach_m_per_s;
      mass_term += t.force * t.force * e.inverse_mass;
      min_restitution = std::min(min_restitution, restitution_coefficient);
      kernel_->add(mean_.data(), shapes_[c], t.force, padded);
      any = true;
    }
    if (!any)
      return;
    const double quadratic = mass_term + kernel_->dot(mean_.data(), mean_.data(), padded); // J.A J
    const double theta = std::min(1.0, (1 + min_restitution) * work / quadratic);
    kernel_->add(m.real, mean_.data(), theta, padded);
    for (std::size_t c = 0; c < count; ++c) {
      Exciter& e = exciters_[group.slots[c]];
      if (system_[c].acts) {
        const double impulse = theta * system_[c].force;
        e.velocity_m_per_s -= impulse * e.inverse_mass;
        e.impulse_ns += impulse;
        e.record_impulse(impulse, h);
      }
    }
    for (std::size_t c = 0; c < count; ++c) {
      Exciter& e = exciters_[group.slots[c]];
      const bool strikes = e.kind == Exciter::Kind::kImpact;
      e.approach_m_per_s = (strikes ? e.velocity_m_per_s : e.rubbing_m_per_s) - velocity_at(c);
      e.mean_velocity_m_per_s = e.approach_m_per_s;
    }
  }
}

} // namespace tactus::contact

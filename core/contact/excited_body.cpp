#include "core/contact/excited_body.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::contact {
namespace {

constexpr double kMaxShape = 1e3;

/// Largest length of the packed arrays: the modes of each island are padded at both ends.
std::size_t packed_modes(std::size_t modes, std::size_t exciters) noexcept {
  return modes + 2 * kModeLanes * std::min(exciters, modes);
}

} // namespace

ExcitedBody::ExcitedBody(std::size_t max_modes, std::size_t exciters, std::size_t pickups,
                         simd::VectorSet widest)
    : body_(max_modes), kernel_(body_kernel(widest)), exciters_(exciters),
      shape_(exciters, std::vector<double>(max_modes, 1)),
      pickup_shape_(pickups, std::vector<double>(max_modes, 1)),
      point_shape_(exciters, ModeArray(max_modes)), pickup_real_(pickups, ModeArray(max_modes)),
      pickup_imaginary_(pickups, ModeArray(max_modes)), mean_(max_modes), point_memory_(max_modes),
      system_(exciters, widest), point_modes_(max_modes, exciters), in_use_(max_modes, exciters),
      islands_(max_modes, exciters), pressed_(exciters), before_real_(max_modes),
      before_imaginary_(max_modes), packed_points_(packed_modes(max_modes, exciters)),
      few_(exciters), sleep_(exciters), island_of_(exciters) {
  for (std::vector<std::size_t>* const slots :
       {&order_, &sorted_, &single_, &single_awake_, &single_near_})
    slots->reserve(exciters);
  shapes_.reserve(exciters);
  packed_.reserve(exciters);
  sleep_until_.reserve(exciters);
  const ModeArray none(packed_modes(max_modes, exciters));
  packed_level_ = {none, none, none, none, none, none, none};
  packed_real_ = packed_imaginary_ = packed_decay_over_omega_ = none;
  packed_shapes_ = ModeArray(exciters * whole_lanes(max_modes));
  same_as_previous_.reserve(exciters);
  compute_step_lengths();
  near_slots_.reserve(exciters);
  forces_.reserve(exciters);
  const std::size_t unknowns = std::min(exciters, max_modes); // unknowns of solve_by_mode()
  matrix_ = ModeArray(unknowns * whole_lanes(unknowns));
  right_ = other_ = ModeArray(unknowns);
  for (std::size_t i = 0; i < exciters; ++i)
    exciters_[i].noise.seed(i + 1);
}

/// Sets the views of the body's arrays. They are pointers: in a copied object they would still
/// point into the original.
void ExcitedBody::update_views() noexcept {
  all_modes_ = view(0, 0, body_.padded());
  order_stale_ = true;
  coupled_ = predicted_ = islands_predicted_ = false;
}

void ExcitedBody::prepare(double sample_rate) noexcept {
  if (sample_rate == body_.sample_rate())
    return update_views();
  store_depths();
  body_.prepare(sample_rate);
  compute_step_lengths();
  restore_depths();
}

void ExcitedBody::compute_step_lengths() noexcept {
  for (std::size_t l = 0; l < kLevels; ++l)
    step_s_[l] = 1 / (body_.sample_rate() * static_cast<double>(1U << l));
}

void ExcitedBody::set_modes(std::span<const Mode> modes) noexcept {
  store_depths();
  body_.set_modes(modes);
  restore_depths();
}

void ExcitedBody::set_contact_shape(std::size_t slot, std::span<const double> shape) noexcept {
  if (slot >= exciters_.size())
    return;
  wake(slot);
  store_depth(slot);
  for (std::size_t i = 0; i < shape_[slot].size(); ++i)
    shape_[slot][i] = i < shape.size() ? bounded(shape[i], kMaxShape) : 0;
  compute_point(slot);
  order_stale_ = true;
  coupled_ = false;
}

void ExcitedBody::set_pickup(std::size_t pickup, std::span<const double> shape) noexcept {
  if (pickup >= pickup_shape_.size())
    return;
  for (std::size_t i = 0; i < pickup_shape_[pickup].size(); ++i)
    pickup_shape_[pickup][i] = i < shape.size() ? bounded(shape[i], kMaxShape) : 0;
  compute_pickup(pickup);
}

void ExcitedBody::compute_pickup(std::size_t pickup) noexcept {
  output_known_ = false;
  for (std::size_t i = 0; i < body_.max_modes(); ++i) {
    pickup_real_[pickup][i] = pickup_shape_[pickup][i] * body_.inverse_sqrt_mass(i);
    pickup_imaginary_[pickup][i] = -pickup_real_[pickup][i] * body_.decay_over_omega[i];
  }
}

/// Before the contact point changes: keeps the penetration of the mass.
void ExcitedBody::store_depth(std::size_t slot) noexcept {
  if (exciters_[slot].kind == Exciter::Kind::kImpact)
    exciters_[slot].depth_m = exciters_[slot].position_m - surface(slot);
}

/// Before the body changes: keeps the penetration of every mass.
void ExcitedBody::store_depths() noexcept {
  wake_all();
  for (std::size_t i = 0; i < exciters_.size(); ++i)
    store_depth(i);
}

/// After the body has changed: restores the penetration of every mass.
void ExcitedBody::restore_depths() noexcept {
  for (std::size_t i = 0; i < exciters_.size(); ++i)
    compute_point(i);
  for (std::size_t pickup = 0; pickup < pickup_shape_.size(); ++pickup)
    compute_pickup(pickup);
  update_views();
  active_modes_ = 0;
  for (std::size_t i = 0; i < body_.modes(); ++i)
    active_modes_ += body_.inverse_sqrt_mass(i) > 0;
}

void ExcitedBody::compute_point(std::size_t slot) noexcept {
  Exciter& e = exciters_[slot];
  ModeArray& point = point_shape_[slot];
  const bool strikes = e.kind == Exciter::Kind::kImpact;
  e.inverse_mass = strikes ? 1 / e.mass_kg : 0;
  e.impulse_mobility = e.inverse_mass;
  for (std::size_t i = 0; i < body_.max_modes(); ++i)
    point[i] = shape_[slot][i] * body_.inverse_sqrt_mass(i);
  point_modes_.set(slot, {point.data(), body_.modes()});
  FewModes& few = few_[slot];
  few.count = static_cast<std::uint32_t>(point_modes_[slot].size());
  for (std::size_t k = 0; k < std::min<std::size_t>(few.count, kFewModes); ++k) {
    few.mode[k] = point_modes_[slot][k];
    few.shape[k] = point[few.mode[k]];
  }
  for (const std::uint32_t i : point_modes_[slot])
    e.impulse_mobility += point[i] * point[i];
  for (std::size_t l = 0; l < kLevels; ++l) {
    double sum = 0.5 * step_s_[l] * e.inverse_mass;
    for (const std::uint32_t i : point_modes_[slot])
      sum += point[i] * point[i] * body_.level(l).mobility[i];
    e.mobility[l] = sum;
  }
  e.effective_mass_kg = e.impulse_mobility > 0 ? 1 / e.impulse_mobility : 1;
  e.level_energy_j = -1;
  if (strikes)
    e.position_m = e.depth_m + surface(slot);
  else
    find_friction_level(e);
  e.depth_valid = false;
}

void ExcitedBody::find_friction_level(Exciter& e) const noexcept {
  e.level = 0;
  double steps = e.rubbing_steps(step_s_[0]);
  while (steps > 1) {
    steps *= 0.5;
    ++e.level;
  }
}

void ExcitedBody::set_impact(std::size_t slot, const ImpactLaw& law, double mass_kg) noexcept {
  if (slot >= exciters_.size())
    return;
  wake(slot);
  Exciter& e = exciters_[slot];
  const double mass = std::isfinite(mass_kg) ? std::clamp(mass_kg, 1e-6, 1e6) : 0.01;
  if (e.kind == Exciter::Kind::kImpact && mass > e.mass_kg) // keeps the kinetic energy
    e.velocity_m_per_s *= std::sqrt(e.mass_kg / mass);
  e.mass_kg = mass;
  if (e.kind != Exciter::Kind::kImpact) {
    clear(slot);
    e.kind = Exciter::Kind::kImpact;
    e.position_m = surface(slot) - 1;
    e.velocity_m_per_s = 0;
  }
  e.depth_m = e.position_m - surface(slot);
  e.impact.set(law);
  compute_point(slot);
  order_stale_ = true;
  coupled_ = false;
}

void ExcitedBody::set_friction(std::size_t slot, const FrictionLaw& law) noexcept {
  if (slot >= exciters_.size())
    return;
  wake(slot);
  Exciter& e = exciters_[slot];
  if (e.kind != Exciter::Kind::kFriction) {
    clear(slot);
    e.kind = Exciter::Kind::kFriction;
    compute_point(slot);
  }
  e.friction.set(law);
  find_friction_level(e);
  order_stale_ = true;
  coupled_ = false;
}

void ExcitedBody::clear(std::size_t slot) noexcept {
  if (slot >= exciters_.size())
    return;
  wake(slot);
  Exciter& e = exciters_[slot];
  e.kind = Exciter::Kind::kNone;
  e.impact.release();
  e.friction.release();
  e.external_force_n = e.normal_force_n = e.rubbing_m_per_s = e.force_n = e.last_force_n = 0;
  e.near = e.depth_valid = false;
  e.ongoing = {};
  order_stale_ = true;
}

void ExcitedBody::launch_mass(std::size_t slot, double gap_m, double velocity) noexcept {
  if (slot >= exciters_.size() || exciters_[slot].kind != Exciter::Kind::kImpact)
    return;
  wake(slot);
  Exciter& e = exciters_[slot];
  e.impact.release();
  e.ongoing = {};
  e.position_m = surface(slot) - bounded(gap_m, kMaxDistance);
  e.velocity_m_per_s = bounded(velocity, kMaxSpeed);
  e.depth_valid = e.near = false;
  order_stale_ = true;
}

void ExcitedBody::set_mass_force(std::size_t slot, double force_n) noexcept {
  if (slot >= exciters_.size())
    return;
  const double force = bounded(force_n, kMaxForce);
  if (pressed_.holds(slot))
    return pressed_.set_external_force(slot, force);
  if (force == exciters_[slot].external_force_n)
    return;
  wake(slot);
  exciters_[slot].external_force_n = force;
  drives_changed_ = true;
}

void ExcitedBody::rub(std::size_t slot, double normal_force_n, double velocity) noexcept {
  if (slot >= exciters_.size())
    return;
  if (normal_force_n > 0) // without a normal force there is no contact
    wake(slot);
  exciters_[slot].rub(normal_force_n, velocity);
  drives_changed_ = true;
}

void ExcitedBody::seed(std::size_t slot, std::uint64_t seed) noexcept {
  if (slot < exciters_.size())
    exciters_[slot].noise.seed(seed);
}

void ExcitedBody::apply_impulse(std::size_t slot, double impulse_ns) noexcept {
  const double impulse = bounded(impulse_ns, kMaxForce);
  if (slot >= exciters_.size() || impulse == 0)
    return;
  wake_around(slot);
  for (std::size_t i = 0; i < exciters_.size(); ++i)
    if (pressed_.holds(i))
      release_pressed(i);
  for (const std::uint32_t i : point_modes_[slot])
    body_.real[i] += impulse * point_shape_[slot][i];
  ringing_ = true;
  invalidate_prediction();
  for (Exciter& e : exciters_)
    e.depth_valid = false;
}

void ExcitedBody::set_min_steps(unsigned steps) noexcept {
  wake_all();
  min_level_ = 0;
  while (min_level_ + 1 < kLevels && (1U << min_level_) < steps)
    ++min_level_;
}

/// If a force at the point moves only one or two modes, the sum runs over these alone. The result
/// has the bits of the sum over all modes, because the other terms are 0.
double ExcitedBody::surface(std::size_t slot) const noexcept {
  if (!ringing_)
    return 0;
  const FewModes& few = few_[slot];
  if (few.count > 2)
    return kernel_->dot(point_shape_[slot].data(), body_.imaginary.data(),
                        body_.displacement.data(), body_.padded());
  double sum = 0;
  for (std::size_t k = 0; k < few.count; ++k)
    sum += few.shape[k] * body_.imaginary[few.mode[k]] * body_.displacement[few.mode[k]];
  return sum;
}

double ExcitedBody::surface_velocity(std::size_t slot) const noexcept {
  if (!ringing_)
    return 0;
  const FewModes& few = few_[slot];
  if (few.count > 2)
    return kernel_->velocity(point_shape_[slot].data(), body_.real.data(), body_.imaginary.data(),
                             body_.decay_over_omega.data(), body_.padded());
  double sum = 0;
  for (std::size_t k = 0; k < few.count; ++k)
    sum += few.shape[k] * (body_.real[few.mode[k]] -
                           body_.decay_over_omega[few.mode[k]] * body_.imaginary[few.mode[k]]);
  return sum;
}

double ExcitedBody::pickup_velocity(std::size_t pickup) const noexcept {
  if (pickup == 0 && output_known_)
    return output_m_per_s_;
  return ringing_ ? kernel_->dots(pickup_real_[pickup].data(), body_.real.data(),
                                  pickup_imaginary_[pickup].data(), body_.imaginary.data(),
                                  body_.padded())
                  : 0.0;
}

double ExcitedBody::energy() const noexcept {
  double sum = body_.energy();
  for (std::size_t i = 0; i < exciters_.size(); ++i)
    sum += exciter(i).energy();
  return sum;
}

void ExcitedBody::reset() noexcept {
  wake_all();
  body_.silence();
  invalidate_prediction();
  ringing_ = false;
  for (Exciter& e : exciters_) {
    e.impact.release();
    e.friction.release();
    e.ongoing = e.last = {};
    e.impact_count = 0;
    e.position_m = e.depth_m = -1;
    e.velocity_m_per_s = e.force_n = e.last_force_n = 0;
    e.near = e.depth_valid = false;
    if (e.kind != Exciter::Kind::kFriction)
      e.level = 0;
  }
  level_ = coarse_count_ = near_ = 0;
  near_slots_.clear();
  single_near_.clear();
  clock_ = 0;
  order_stale_ = true;
  coupled_ = false;
}

ModesView ExcitedBody::view(std::size_t index, std::size_t first, std::size_t end) noexcept {
  const ModalBody::Level& level = body_.level(index);
  return {body_.real.data() + first,
          body_.imaginary.data() + first,
          level.pole_real.data() + first,
          level.pole_imaginary.data() + first,
          level.response_real.data() + first,
          level.response_imaginary.data() + first,
          level.mean_real.data() + first,
          level.mean_imaginary.data() + first,
          level.mobility.data() + first,
          body_.decay_over_omega.data() + first,
          end - first};
}

} // namespace tactus::contact

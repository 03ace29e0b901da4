#include "core/contact/excited_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

/// One sample of a body: finds the near exciters, chooses how fine the steps are, and makes the
/// steps of one island.
namespace tactus::contact {
namespace {

constexpr double kMaxStepAngle = 0.15; // rad: phase advance of a contact's oscillation in a step
constexpr double kImpulseAngle = 0.5;  // rad in the finest step: above it, an impulse replaces the
                                       // contact
constexpr double kLookAhead = 2;       // samples: a mass that may touch the surface within this
                                       // time is near
constexpr std::uint64_t kProximityPeriod = 16; // samples between measurements of the depths
constexpr std::size_t kCoarseningDelay = 8;    // samples before steps become coarser

} // namespace

bool ExcitedBody::precedes(std::size_t a, std::size_t b) const noexcept {
  const auto numbers = [](const Exciter& e) {
    const ImpactLaw& i = e.impact.law();
    const FrictionLaw& f = e.friction.law();
    return std::array{static_cast<double>(e.kind),
                      e.mass_kg,
                      e.position_m,
                      e.velocity_m_per_s,
                      e.external_force_n,
                      e.normal_force_n,
                      e.rubbing_m_per_s,
                      e.depth_m,
                      e.approach_m_per_s,
                      e.impact.stored_j(),
                      e.impact.energy_account_j(),
                      e.friction.bend_m(),
                      i.stiffness,
                      i.exponent,
                      i.dissipation_s_per_m,
                      i.compliance_m_per_n,
                      f.static_coefficient,
                      f.dynamic_coefficient,
                      f.stribeck_m_per_s,
                      f.breakaway,
                      f.stiffness_n_per_m,
                      f.damping_ns_per_m,
                      f.viscosity_ns_per_m,
                      f.roughness};
  };
  const auto first = numbers(exciters_[a]), second = numbers(exciters_[b]);
  if (first != second)
    return first < second;
  return shape_[a] < shape_[b];
}

void ExcitedBody::sort() noexcept {
  wake_all();
  find_islands_in_use();
  std::sort(sorted_.begin(), sorted_.end(),
            [this](std::size_t a, std::size_t b) { return precedes(a, b); });
  list_awake();
  order_stale_ = coupled_ = islands_valid_ = range_known_ = drives_changed_ = false;
}

/// Lists the exciters that update_proximity() checks, in the order of sort().
void ExcitedBody::list_awake() noexcept {
  const auto awake = [this](std::size_t slot) {
    return !sleep_[slot].sleeps && !pressed_.holds(slot);
  };
  order_.clear();
  std::copy_if(sorted_.begin(), sorted_.end(), std::back_inserter(order_), awake);
  single_awake_.clear();
  std::copy_if(single_.begin(), single_.end(), std::back_inserter(single_awake_), awake);
  awake_changed_ = false;
  has_identical_ = false;
  same_as_previous_.assign(order_.size(), 0);
  for (std::size_t i = 1; i < order_.size(); ++i)
    if (!precedes(order_[i - 1], order_[i]))
      same_as_previous_[i] = has_identical_ = true;
}

/// Exciters that were identical must be sorted again once they are driven differently.
void ExcitedBody::check_symmetry() noexcept {
  for (std::size_t i = 1; i < order_.size() && !order_stale_; ++i) {
    const Exciter &a = exciters_[order_[i - 1]], &b = exciters_[order_[i]];
    order_stale_ = same_as_previous_[i] &&
                   (a.external_force_n != b.external_force_n ||
                    a.normal_force_n != b.normal_force_n || a.rubbing_m_per_s != b.rubbing_m_per_s);
  }
  drives_changed_ = false;
}

/// Chooses the level of a contact from its energy: kinetic energy of the approach and stored
/// energy.
void ExcitedBody::find_level(Exciter& e) const noexcept {
  const double mass = e.effective_mass_kg;
  const double energy = 0.5 * mass * e.approach_m_per_s * e.approach_m_per_s + e.impact.stored_j();
  if (e.level_valid(energy))
    return;
  e.level_energy_j = energy;
  const double angle = std::sqrt(e.impact.stiffest(energy, mass)) * step_s_[0];
  constexpr double kFinest = 1U << (kLevels - 1);
  e.impulsive = angle / kFinest > kImpulseAngle;
  e.level = 0;
  for (double steps = 1; e.level + 1 < kLevels && angle > kMaxStepAngle * steps; steps *= 2)
    ++e.level;
}

/// Advances a mass that is far from the body by a sample.
void ExcitedBody::advance_free_mass(Exciter& e) const noexcept {
  const double sample = step_s_[0], before = e.velocity_m_per_s;
  e.velocity_m_per_s =
      std::clamp(before + sample * e.external_force_n * e.inverse_mass, -kMaxSpeed, kMaxSpeed);
  e.position_m += 0.5 * sample * (before + e.velocity_m_per_s);
  if (!(std::abs(e.position_m) < kMaxDistance)) {
    e.position_m = std::clamp(e.position_m, -kMaxDistance, kMaxDistance);
    e.velocity_m_per_s = 0;
  }
}

/// True if the exciter may touch within this sample. With `measure`, it computes the depth from the
/// positions of mass and surface, which removes the rounding errors of the steps.
bool ExcitedBody::update_proximity_of(std::size_t i, bool measure) noexcept {
  Exciter& e = exciters_[i];
  if (e.kind == Exciter::Kind::kFriction) {
    e.near = e.normal_force_n > 0;
    if (!e.depth_valid)
      e.approach_m_per_s = e.mean_velocity_m_per_s = e.rubbing_m_per_s - surface_velocity(i);
    if (!e.near) {
      e.friction.release();
      e.last_force_n = 0;
    }
  } else {
    if (!e.depth_valid || measure) {
      e.depth_m = e.position_m - surface(i);
      e.approach_m_per_s = e.velocity_m_per_s - surface_velocity(i);
      if (!e.depth_valid)
        e.mean_velocity_m_per_s = e.approach_m_per_s;
    }
    const double sample = step_s_[0];
    const double next_approach = e.approach_m_per_s + sample * e.external_force_n * e.inverse_mass;
    e.near =
        e.impact.touching() || e.depth_m + kLookAhead * sample * std::max(next_approach, 0.0) > 0;
    if (e.near)
      find_level(e);
    else
      advance_free_mass(e);
  }
  e.depth_valid = e.near;
  e.force_n = e.impulse_ns = e.dissipated_j = 0;
  return e.near;
}

/// Finds the exciters that may touch within this sample, and the level of its steps.
void ExcitedBody::update_proximity() noexcept {
  if (used_ > 1 && clock_ % kFlushPeriod == 0)
    update_sleep();
  if (awake_changed_)
    list_awake();
  const bool measure = clock_ % kProximityPeriod == 0;
  const std::size_t before = near_;
  bool same = true;
  near_ = 0;
  for (const std::size_t i : order_) {
    if (!update_proximity_of(i, measure))
      continue;
    same = same && near_ < before && near_slots_[near_] == i;
    if (near_ < near_slots_.size())
      near_slots_[near_] = i;
    else
      near_slots_.push_back(i);
    ++near_;
  }
  near_slots_.resize(near_);
  if (!pressed_.empty())
    update_pressed(measure);
  if (!single_awake_.empty() || !single_near_.empty())
    update_single_contacts(measure);
  coupled_ = coupled_ && same && near_ == before;
  range_known_ = range_known_ && same && near_ == before;
  islands_valid_ = islands_valid_ && range_known_;
  predicted_ = predicted_ && near_ == 1 && clock_ % kFlushPeriod != 0;
  if (!range_known_)
    find_range();
  single_range_ = one_range_ && !any_single_near();
  if (single_range_)
    choose_level();
}

void ExcitedBody::update_single_contacts(bool measure) noexcept {
  single_near_.clear();
  single_at_level_ = {};
  for (const std::size_t i : single_awake_)
    if (update_proximity_of(i, measure)) {
      single_near_.push_back(i);
      ++single_at_level_[std::max(min_level_, exciters_[i].level)];
    }
}

/// Chooses the level of the only island. Finer steps start at once, coarser ones after a delay.
void ExcitedBody::choose_level() noexcept {
  std::size_t required_level = min_level_;
  for (const std::size_t i : near_slots_)
    required_level = std::max(required_level, exciters_[i].level);
  if (near_ > 1)
    while (required_level > 0 && (work(near_, body_.modes()) << required_level) > kMaxWork)
      --required_level;
  coarse_count_ = required_level < level_ ? coarse_count_ + 1 : 0;
  if (required_level > level_ ||
      (coarse_count_ > kCoarseningDelay && (near_ == 0 || required_level + 1 < level_)) ||
      (near_ > 1 && required_level < level_))
    change_level(required_level);
}

void ExcitedBody::change_level(std::size_t level) noexcept {
  if (level == level_)
    return;
  level_ = level;
  coarse_count_ = 0;
  coupled_ = false;
}

/// Coefficients of one contact point for the steps of these modes.
PointView ExcitedBody::make_point_view(const ModesView& m, const double* shape,
                                       const PointArrays& into) noexcept {
  double next_mobility = 0;
  for (std::size_t i = 0; i < m.padded; ++i) {
    into.response_at_point_real[i] = shape[i] * m.response_real[i];
    into.response_at_point_imaginary[i] = shape[i] * m.response_imaginary[i];
    // The mean velocity of the step after a state z is Re((mean_real - j mean_imaginary) z).
    const double real = shape[i] * m.mean_real[i], imaginary = shape[i] * m.mean_imaginary[i];
    next_mobility +=
        real * into.response_at_point_real[i] + imaginary * into.response_at_point_imaginary[i];
    // For the step after that, z becomes P z.
    into.next_mean_real[i] = real * m.pole_real[i] + imaginary * m.pole_imaginary[i];
    into.next_mean_imaginary[i] = imaginary * m.pole_real[i] - real * m.pole_imaginary[i];
  }
  return {shape,
          into.response_at_point_real,
          into.response_at_point_imaginary,
          into.next_mean_real,
          into.next_mean_imaginary,
          next_mobility};
}

void ExcitedBody::prepare_single_contact(std::size_t slot) noexcept {
  point_view_ =
      make_point_view(view(), point_shape_[slot].data() + range_first_, point_memory_.from(0));
  coupled_ = true;
  predicted_ = false;
}

/// Advances the only contact on these modes by a sample.
void ExcitedBody::step_only_contact(std::size_t slot, const ModesView& modes,
                                    const PointView& point, Prediction& prediction, bool& predicted,
                                    std::size_t level) noexcept {
  Exciter& e = exciters_[slot];
  if (!predicted)
    prediction = kernel_->predict(modes, point);
  predicted = true;
  const bool strikes = e.kind == Exciter::Kind::kImpact;
  const double drive = strikes ? e.external_force_n : e.rubbing_m_per_s, normal = e.normal_force_n;
  kernel_->advance_contact(modes, point, prediction, e, {step_s_[level], level},
                           {&drive, &normal, nullptr, nullptr, nullptr, nullptr, 1});
}

/// Advances modes first ... end - 1 by a sample without contacts.
void ExcitedBody::ring(std::size_t first, std::size_t end) noexcept {
  if (first < end)
    kernel_->ring(view(0, first, end));
}

/// Advances a body without contacts by a sample, and computes its output at the first pickup.
void ExcitedBody::step_free() noexcept {
  invalidate_prediction();
  if (pickup_real_.empty())
    return ring(0, body_.padded());
  output_m_per_s_ =
      kernel_->ring_with_output(all_modes_, pickup_real_[0].data(), pickup_imaginary_[0].data());
  output_known_ = true;
}

/// Advances the only island by a sample, on its range of modes.
void ExcitedBody::step_in_place() noexcept {
  ringing_ = true;
  if (near_ == 1) {
    if (!coupled_)
      prepare_single_contact(near_slots_[0]);
    step_only_contact(near_slots_[0], view(), point_view_, prediction_, predicted_, level_);
    islands_predicted_ = false;
  } else {
    system_.select_all();
    shapes_.clear();
    for (const std::size_t i : near_slots_)
      shapes_.push_back(point_shape_[i].data() + range_first_);
    const Group group{near_slots_, view(), std::min(range_end_, body_.modes()) - range_first_,
                      level_};
    invalidate_prediction();
    if (!coupled_ || near_ == 1) {
      couple(group);
      packed_.clear(); // their coupling matrices were in the same memory
    }
    coupled_ = near_ > 1; // with one contact, coupled_ refers to point_view_
    step_coupled(group);
  }
  ring(0, range_first_);
  ring(range_end_, body_.padded());
}

/// True if update_proximity() would change nothing, so that the kernel can run several samples.
bool ExcitedBody::can_batch(std::size_t slot) const noexcept {
  const Exciter& e = exciters_[slot];
  if (order_stale_ || used_ != 1 || near_ != 1 || near_slots_[0] != slot || !e.depth_valid ||
      !predicted_ || !coupled_ || range_end_ - range_first_ != body_.padded() ||
      clock_ % kProximityPeriod == 0)
    return false;
  if (e.kind == Exciter::Kind::kFriction)
    return std::max(e.level, min_level_) == level_;
  return e.impact.touching() && std::max(e.level, min_level_) == level_ &&
         e.level_valid(0.5 * e.effective_mass_kg * e.approach_m_per_s * e.approach_m_per_s +
                       e.impact.stored_j());
}

/// Skips the first samples in which the body is at rest and the exciter does not approach. Returns
/// their number.
std::size_t ExcitedBody::skip_idle(std::size_t slot, const SampleBatch& batch) noexcept {
  Exciter& e = exciters_[slot];
  if (ringing_ || near_ > 0 || order_stale_ || used_ != 1 || level_ != min_level_)
    return 0;
  std::size_t n = 0;
  if (e.kind == Exciter::Kind::kImpact) {
    for (; n < batch.count && batch.drive[n] == 0 && e.velocity_m_per_s <= 0; ++n) {
      e.external_force_n = 0;
      advance_free_mass(e);
    }
  } else {
    for (; n < batch.count && !(batch.normal[n] > 0); ++n)
      rub(slot, batch.normal[n], batch.drive[n]);
  }
  std::fill_n(batch.output, n, 0.0);
  std::fill_n(batch.force, n, 0.0);
  clock_ += n;
  return n;
}

void ExcitedBody::run(std::size_t slot, const SampleBatch& batch) noexcept {
  if (slot >= exciters_.size() || pickup_shape_.empty())
    return;
  Exciter& e = exciters_[slot];
  for (std::size_t n = 0; n < batch.count;) {
    const double normal = batch.normal ? batch.normal[n] : 0;
    const std::size_t idle_samples =
        skip_idle(slot, {batch.drive + n, batch.normal ? batch.normal + n : nullptr,
                         batch.output + n, batch.force + n, nullptr, nullptr, batch.count - n});
    if (idle_samples > 0) {
      n += idle_samples;
      continue;
    }
    if (can_batch(slot)) {
      const std::size_t room =
          std::min<std::size_t>(batch.count - n, kProximityPeriod - clock_ % kProximityPeriod);
      const std::size_t done = kernel_->advance_contact(
          view(), point_view_, prediction_, e, {step_length(), level_},
          {batch.drive + n, batch.normal ? batch.normal + n : nullptr, batch.output + n,
           batch.force + n, pickup_real_[0].data(), pickup_imaginary_[0].data(), room});
      if (done > 0) {
        coarse_count_ = 0;
        clock_ += done;
        n += done;
        check_state();
        continue;
      }
    }
    if (e.kind == Exciter::Kind::kFriction)
      rub(slot, normal, batch.drive[n]);
    else
      set_mass_force(slot, batch.drive[n]);
    step();
    batch.output[n] = pickup_velocity(0);
    batch.force[n] = force(slot);
    ++n;
  }
}

void ExcitedBody::run_mass(std::size_t slot, std::span<const double> force_n,
                           std::span<double> output, std::span<double> contact_n) noexcept {
  run(slot, {force_n.data(), nullptr, output.data(), contact_n.data(), nullptr, nullptr,
             std::min({force_n.size(), output.size(), contact_n.size()})});
}

void ExcitedBody::run_rub(std::size_t slot, std::span<const double> velocity_m_per_s,
                          std::span<const double> normal_force_n, std::span<double> output,
                          std::span<double> friction_n) noexcept {
  run(slot, {velocity_m_per_s.data(), normal_force_n.data(), output.data(), friction_n.data(),
             nullptr, nullptr,
             std::min({velocity_m_per_s.size(), normal_force_n.size(), output.size(),
                       friction_n.size()})});
}

void ExcitedBody::step() noexcept {
  if (has_identical_ && drives_changed_)
    check_symmetry();
  if (order_stale_)
    sort();
  output_known_ = false;
  if (clock_ % kFlushPeriod != 0 && all_sleep())
    coarse_count_ = 0;
  else
    update_proximity();
  ++clock_;
  if (!single_range_)
    step_islands();
  else if (near_ > 0)
    step_in_place();
  else if (ringing_)
    step_free();
  check_state();
}

/// After a sample: resets the body if a state is out of range, and ends inaudible vibration.
void ExcitedBody::check_state() noexcept {
  bool valid = true;
  const auto check = [&](std::size_t i) {
    Exciter& e = exciters_[i];
    valid =
        valid && std::abs(e.force_n) < kMaxState && std::abs(e.mean_velocity_m_per_s) < kMaxState;
    if (e.kind == Exciter::Kind::kImpact && !(std::abs(e.velocity_m_per_s) < kMaxSpeed)) {
      e.velocity_m_per_s = bounded(e.velocity_m_per_s, kMaxSpeed);
      e.depth_valid = false;
    }
  };
  for (const std::size_t i : near_slots_)
    check(i);
  for (const std::size_t i : single_near_)
    check(i);
  if (!valid)
    return reset();
  if (clock_ % kFlushPeriod == 0 && ringing_) {
    output_known_ = false;
    if (!body_.flush_denormals())
      reset();
    else if (near_ == 0 && !any_single_near())
      ringing_ = body_.energy() > 0;
  }
}

} // namespace tactus::contact

#include "core/contact/touched_body.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::contact {
namespace {

constexpr double kMostShape = 1e3;

/// Each island's modes are rounded to whole lanes at both ends.
std::size_t packed_modes(std::size_t modes, std::size_t exciters) noexcept {
  return modes + 2 * kModeLanes * std::min(exciters, modes);
}

} // namespace

TouchedBody::TouchedBody(std::size_t max_modes, std::size_t exciters, std::size_t ears)
    : body_(max_modes), kernel_(&body_kernel()), exciters_(exciters),
      shape_(exciters, std::vector<double>(max_modes, 1)),
      ear_shape_(ears, std::vector<double>(max_modes, 1)), place_(exciters, ModeArray(max_modes)),
      ear_real_(ears, ModeArray(max_modes)), ear_imaginary_(ears, ModeArray(max_modes)),
      outer_(max_modes), mean_(max_modes), place_memory_(max_modes), system_(exciters),
      place_modes_(max_modes, exciters), in_use_(max_modes, exciters),
      islands_(max_modes, exciters), pressed_(exciters), before_real_(max_modes),
      before_imaginary_(max_modes), packed_places_(packed_modes(max_modes, exciters)),
      few_(exciters), sleep_(exciters), community_(exciters) {
  for (std::vector<std::size_t>* const slots :
       {&order_, &sorted_, &lone_, &lone_awake_, &lone_near_})
    slots->reserve(exciters);
  shapes_.reserve(exciters);
  packed_.reserve(exciters);
  wakes_at_.reserve(exciters);
  const ModeArray none(packed_modes(max_modes, exciters));
  packed_level_ = {none, none, none, none, none, none, none};
  packed_real_ = packed_imaginary_ = packed_slowing_ = packed_outer_ = none;
  packed_shapes_ = ModeArray(exciters * whole_lanes(max_modes));
  like_the_one_before_.reserve(exciters);
  work_out_steps();
  close_.reserve(exciters);
  pushes_.reserve(exciters);
  const std::size_t unknowns = std::min(exciters, max_modes); // with more contacts than modes
  matrix_ = ModeArray(unknowns * whole_lanes(unknowns));
  right_ = other_ = ModeArray(unknowns);
  for (std::size_t i = 0; i < exciters; ++i)
    exciters_[i].noise.seed(i + 1);
}

void TouchedBody::prepare(double sample_rate) noexcept {
  if (sample_rate == body_.sample_rate())
    return;
  measure_places();
  body_.prepare(sample_rate);
  work_out_steps();
  keep_places();
}

void TouchedBody::work_out_steps() noexcept {
  for (std::size_t l = 0; l < kLevels; ++l)
    step_s_[l] = 1 / (body_.sample_rate() * static_cast<double>(1U << l));
}

void TouchedBody::set_modes(std::span<const Mode> modes) noexcept {
  measure_places();
  body_.set_modes(modes);
  keep_places();
}

void TouchedBody::set_place(std::size_t slot, std::span<const double> shape) noexcept {
  if (slot >= exciters_.size())
    return;
  wake(slot);
  measure_place(slot);
  for (std::size_t i = 0; i < shape_[slot].size(); ++i)
    shape_[slot][i] = i < shape.size() ? bounded(shape[i], kMostShape) : 0;
  work_out_place(slot);
  unsorted_ = true;
  coupled_ = false;
}

void TouchedBody::set_ear(std::size_t ear, std::span<const double> shape) noexcept {
  if (ear >= ear_shape_.size())
    return;
  for (std::size_t i = 0; i < ear_shape_[ear].size(); ++i)
    ear_shape_[ear][i] = i < shape.size() ? bounded(shape[i], kMostShape) : 0;
  work_out_ear(ear);
}

void TouchedBody::work_out_ear(std::size_t ear) noexcept {
  heard_known_ = false;
  for (std::size_t i = 0; i < body_.max_modes(); ++i) {
    ear_real_[ear][i] = ear_shape_[ear][i] * body_.per_root_mass(i);
    ear_imaginary_[ear][i] = -ear_real_[ear][i] * body_.slowing[i];
  }
}

/// Before the place changes: where the mass is above its surface.
void TouchedBody::measure_place(std::size_t slot) noexcept {
  if (exciters_[slot].kind == Exciter::Kind::kImpact)
    exciters_[slot].depth_m = exciters_[slot].place_m - surface(slot);
}

/// Before the body changes: where every mass is above its surface.
void TouchedBody::measure_places() noexcept {
  wake_all();
  for (std::size_t i = 0; i < exciters_.size(); ++i)
    measure_place(i);
}

/// After the body has changed: the masses are where they were above it.
void TouchedBody::keep_places() noexcept {
  for (std::size_t i = 0; i < exciters_.size(); ++i)
    work_out_place(i);
  for (std::size_t ear = 0; ear < ear_shape_.size(); ++ear)
    work_out_ear(ear);
  whole_ = view(0, 0, body_.padded());
  sounding_ = 0;
  for (std::size_t i = 0; i < body_.modes(); ++i)
    sounding_ += body_.per_root_mass(i) > 0;
  unsorted_ = true;
  coupled_ = false;
}

void TouchedBody::work_out_place(std::size_t slot) noexcept {
  Exciter& e = exciters_[slot];
  ModeArray& place = place_[slot];
  const bool strikes = e.kind == Exciter::Kind::kImpact;
  e.per_mass = strikes && !e.held ? 1 / e.mass_kg : 0;
  e.quick_mobility = e.per_mass;
  for (std::size_t i = 0; i < body_.max_modes(); ++i)
    place[i] = shape_[slot][i] * body_.per_root_mass(i);
  place_modes_.set(slot, {place.data(), body_.modes()});
  FewModes& few = few_[slot];
  few.count = static_cast<std::uint32_t>(place_modes_[slot].size());
  for (std::size_t k = 0; k < std::min<std::size_t>(few.count, kFewModes); ++k) {
    few.mode[k] = place_modes_[slot][k];
    few.shape[k] = place[few.mode[k]];
  }
  for (const std::uint32_t i : place_modes_[slot])
    e.quick_mobility += place[i] * place[i];
  for (std::size_t l = 0; l < kLevels; ++l) {
    double sum = 0.5 * step_s_[l] * e.per_mass;
    for (const std::uint32_t i : place_modes_[slot])
      sum += place[i] * place[i] * body_.level(l).mobility[i];
    e.mobility[l] = sum;
  }
  e.effective_mass_kg = e.quick_mobility > 0 ? 1 / e.quick_mobility : 1;
  e.judged_j = -1;
  if (strikes)
    e.place_m = e.depth_m + surface(slot);
  else
    judge_rub(e);
  e.fresh = false;
}

void TouchedBody::judge_rub(Exciter& e) const noexcept {
  e.level = 0;
  for (double steps = e.rubbing_steps(step_s_[0]); steps > 1; steps *= 0.5)
    ++e.level;
}

void TouchedBody::set_impact(std::size_t slot, const ImpactLaw& law, double mass_kg) noexcept {
  if (slot >= exciters_.size())
    return;
  wake(slot);
  Exciter& e = exciters_[slot];
  const double mass = std::isfinite(mass_kg) ? std::clamp(mass_kg, 1e-6, 1e6) : 0.01;
  if (e.kind == Exciter::Kind::kImpact && !e.held && mass > e.mass_kg) // no energy from nowhere
    e.velocity_m_per_s *= std::sqrt(e.mass_kg / mass);
  e.mass_kg = mass;
  become_impact(slot, law, false);
}

void TouchedBody::set_held(std::size_t slot, const ImpactLaw& law) noexcept {
  if (slot < exciters_.size())
    become_impact(slot, law, true);
}

void TouchedBody::become_impact(std::size_t slot, const ImpactLaw& law, bool held) noexcept {
  wake(slot);
  Exciter& e = exciters_[slot];
  if (e.kind != Exciter::Kind::kImpact || e.held != held) {
    clear(slot);
    e.kind = Exciter::Kind::kImpact;
    e.held = held;
    e.place_m = surface(slot) - 1;
    e.velocity_m_per_s = 0;
  }
  e.depth_m = e.place_m - surface(slot);
  e.impact.set(law);
  work_out_place(slot);
  unsorted_ = true;
  coupled_ = false;
}

void TouchedBody::set_friction(std::size_t slot, const FrictionLaw& law) noexcept {
  if (slot >= exciters_.size())
    return;
  wake(slot);
  Exciter& e = exciters_[slot];
  if (e.kind != Exciter::Kind::kFriction) {
    clear(slot);
    e.kind = Exciter::Kind::kFriction;
    work_out_place(slot);
  }
  e.friction.set(law);
  judge_rub(e);
  unsorted_ = true;
  coupled_ = false;
}

void TouchedBody::clear(std::size_t slot) noexcept {
  if (slot >= exciters_.size())
    return;
  wake(slot);
  Exciter& e = exciters_[slot];
  e.kind = Exciter::Kind::kNone;
  e.impact.release();
  e.friction.release();
  e.outer_force_n = e.normal_force_n = e.rubbing_m_per_s = e.force_n = e.last_force_n = 0;
  e.near = e.fresh = false;
  e.open = {};
  unsorted_ = true;
}

void TouchedBody::throw_mass(std::size_t slot, double gap_m, double velocity) noexcept {
  if (slot >= exciters_.size() || exciters_[slot].kind != Exciter::Kind::kImpact)
    return;
  wake(slot);
  Exciter& e = exciters_[slot];
  e.impact.release();
  e.open = {};
  e.place_m = surface(slot) - bounded(gap_m, kFarthest);
  e.velocity_m_per_s = bounded(velocity, kFastest);
  e.fresh = e.near = false;
  unsorted_ = true;
}

void TouchedBody::lead(std::size_t slot, double velocity_m_per_s) noexcept {
  if (slot >= exciters_.size() || !exciters_[slot].held)
    return;
  wake(slot);
  exciters_[slot].move_at(velocity_m_per_s);
  moved_ = true;
}

void TouchedBody::push_mass(std::size_t slot, double force_n) noexcept {
  if (slot >= exciters_.size())
    return;
  const double force = bounded(force_n, kMostForce);
  if (pressed_.holds(slot))
    return pressed_.set_outer_force(slot, force);
  if (force == exciters_[slot].outer_force_n)
    return;
  wake(slot);
  exciters_[slot].outer_force_n = force;
  moved_ = true;
}

void TouchedBody::rub(std::size_t slot, double normal_force_n, double velocity) noexcept {
  if (slot >= exciters_.size())
    return;
  if (normal_force_n > 0) // otherwise it stays away
    wake(slot);
  exciters_[slot].rub(normal_force_n, velocity);
  moved_ = true;
}

void TouchedBody::seed(std::size_t slot, std::uint64_t seed) noexcept {
  if (slot < exciters_.size())
    exciters_[slot].noise.seed(seed);
}

void TouchedBody::push_body(std::size_t slot, double force_n) noexcept {
  const double force = bounded(force_n, kMostForce);
  if (slot >= exciters_.size() || force == 0)
    return;
  wake_around(slot);
  for (const std::uint32_t i : place_modes_[slot])
    outer_[i] += force * place_[slot][i];
  has_outer_ = sounds_ = true;
}

void TouchedBody::knock_body(std::size_t slot, double impulse_ns) noexcept {
  const double impulse = bounded(impulse_ns, kMostForce);
  if (slot >= exciters_.size() || impulse == 0)
    return;
  wake_around(slot);
  for (std::size_t i = 0; i < exciters_.size(); ++i)
    if (pressed_.holds(i))
      let_go(i);
  for (const std::uint32_t i : place_modes_[slot])
    body_.real[i] += impulse * place_[slot][i];
  sounds_ = true;
  forget_foresight();
  for (Exciter& e : exciters_)
    e.fresh = false;
}

void TouchedBody::set_modal_velocity(std::size_t mode, double velocity_m_per_s) noexcept {
  if (mode >= body_.modes() || !(body_.per_root_mass(mode) > 0))
    return;
  wake_all();
  body_.real[mode] = bounded(velocity_m_per_s, kFastest) / body_.per_root_mass(mode) +
                     body_.slowing[mode] * body_.imaginary[mode];
  sounds_ = true;
  forget_foresight();
  for (Exciter& e : exciters_)
    e.fresh = false;
}

void TouchedBody::set_least_steps(unsigned steps) noexcept {
  wake_all();
  least_level_ = 0;
  while (least_level_ + 1 < kLevels && (1U << least_level_) < steps)
    ++least_level_;
}

/// Sums over a place's one or two modes run over these alone: the bits are those of the sum over
/// all.
double TouchedBody::surface(std::size_t slot) const noexcept {
  if (!sounds_)
    return 0;
  const FewModes& few = few_[slot];
  if (few.count > 2)
    return kernel_->dot(place_[slot].data(), body_.imaginary.data(), body_.displacement.data(),
                        body_.padded());
  double sum = 0;
  for (std::size_t k = 0; k < few.count; ++k)
    sum += few.shape[k] * body_.imaginary[few.mode[k]] * body_.displacement[few.mode[k]];
  return sum;
}

double TouchedBody::surface_velocity(std::size_t slot) const noexcept {
  if (!sounds_)
    return 0;
  const FewModes& few = few_[slot];
  if (few.count > 2)
    return kernel_->velocity(place_[slot].data(), body_.real.data(), body_.imaginary.data(),
                             body_.slowing.data(), body_.padded());
  double sum = 0;
  for (std::size_t k = 0; k < few.count; ++k)
    sum += few.shape[k] *
           (body_.real[few.mode[k]] - body_.slowing[few.mode[k]] * body_.imaginary[few.mode[k]]);
  return sum;
}

double TouchedBody::hear(std::size_t ear) const noexcept {
  if (ear == 0 && heard_known_)
    return heard_m_per_s_;
  return sounds_ ? kernel_->dots(ear_real_[ear].data(), body_.real.data(),
                                 ear_imaginary_[ear].data(), body_.imaginary.data(), body_.padded())
                 : 0.0;
}

double TouchedBody::energy() const noexcept {
  double sum = body_.energy();
  for (std::size_t i = 0; i < exciters_.size(); ++i)
    sum += exciter(i).energy();
  return sum;
}

void TouchedBody::reset() noexcept {
  wake_all();
  body_.silence();
  forget_foresight();
  outer_.clear();
  has_outer_ = sounds_ = false;
  for (Exciter& e : exciters_) {
    e.impact.release();
    e.friction.release();
    e.open = e.last = {};
    e.blows = 0;
    e.place_m = e.depth_m = -1;
    e.velocity_m_per_s = e.force_n = e.last_force_n = 0;
    e.near = e.fresh = false;
    if (e.kind != Exciter::Kind::kFriction)
      e.level = 0;
  }
  level_ = quiet_ = near_ = 0;
  close_.clear();
  lone_near_.clear();
  clock_ = 0;
  unsorted_ = true;
  coupled_ = false;
}

ModesView TouchedBody::view(std::size_t index, std::size_t first, std::size_t end) noexcept {
  const ModalBody::Level& level = body_.level(index);
  return {body_.real.data() + first,
          body_.imaginary.data() + first,
          level.turn_real.data() + first,
          level.turn_imaginary.data() + first,
          level.response_real.data() + first,
          level.response_imaginary.data() + first,
          level.mean_real.data() + first,
          level.mean_imaginary.data() + first,
          level.mobility.data() + first,
          body_.slowing.data() + first,
          end - first};
}

} // namespace tactus::contact

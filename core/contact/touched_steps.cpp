#include "core/contact/touched_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

/// How a touched body goes on in time: who is near, how fine the steps are, and the steps of one.
namespace tactus::contact {
namespace {

constexpr double kStepsFor = 0.15;   // most angle, rad, that a contact may turn in a step
constexpr double kImpulseFrom = 0.5; // the same in the finest steps: an impulse instead
constexpr double kReach = 2;         // samples ahead in which a mass may arrive
constexpr std::uint64_t kLookEvery = 16;
constexpr std::size_t kPatience = 8; // samples before coarser steps

} // namespace

bool TouchedBody::goes_before(std::size_t a, std::size_t b) const noexcept {
  const auto numbers = [](const Exciter& e) {
    const ImpactLaw& i = e.impact.law();
    const FrictionLaw& f = e.friction.law();
    return std::array{static_cast<double>(e.kind),
                      static_cast<double>(e.held),
                      e.mass_kg,
                      e.place_m,
                      e.velocity_m_per_s,
                      e.outer_force_n,
                      e.normal_force_n,
                      e.rubbing_m_per_s,
                      e.depth_m,
                      e.approach_m_per_s,
                      e.impact.stored_j(),
                      e.impact.bank_j(),
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

void TouchedBody::sort() noexcept {
  wake_all();
  divide_in_use();
  std::sort(sorted_.begin(), sorted_.end(),
            [this](std::size_t a, std::size_t b) { return goes_before(a, b); });
  list_awake();
  unsorted_ = coupled_ = divided_ = range_known_ = moved_ = false;
}

/// Those that look_around() looks at, in the order of sort().
void TouchedBody::list_awake() noexcept {
  const auto awake = [this](std::size_t slot) {
    return !sleep_[slot].sleeps && !pressed_.holds(slot);
  };
  order_.clear();
  std::copy_if(sorted_.begin(), sorted_.end(), std::back_inserter(order_), awake);
  lone_awake_.clear();
  std::copy_if(lone_.begin(), lone_.end(), std::back_inserter(lone_awake_), awake);
  awake_changed_ = false;
  tied_ = false;
  like_the_one_before_.assign(order_.size(), 0);
  for (std::size_t i = 1; i < order_.size(); ++i)
    if (!goes_before(order_[i - 1], order_[i]))
      like_the_one_before_[i] = tied_ = true;
}

/// Exciters that were alike until now get an order when they are driven differently.
void TouchedBody::look_for_difference() noexcept {
  for (std::size_t i = 1; i < order_.size() && !unsorted_; ++i) {
    const Exciter &a = exciters_[order_[i - 1]], &b = exciters_[order_[i]];
    unsorted_ = like_the_one_before_[i] &&
                (a.outer_force_n != b.outer_force_n || a.normal_force_n != b.normal_force_n ||
                 a.rubbing_m_per_s != b.rubbing_m_per_s ||
                 (a.held && a.velocity_m_per_s != b.velocity_m_per_s));
  }
  moved_ = false;
}

/// How fine the steps of a contact must be, from the energy that is in it. Only a new energy makes
/// a new answer.
void TouchedBody::judge(Exciter& e) const noexcept {
  const double mass = e.effective_mass_kg;
  const double energy = 0.5 * mass * e.approach_m_per_s * e.approach_m_per_s + e.impact.stored_j();
  if (e.judged(energy))
    return;
  e.judged_j = energy;
  const double angle = std::sqrt(e.impact.stiffest(energy, mass)) * step_s_[0];
  constexpr double kFinest = 1U << (kLevels - 1);
  e.impulsive = angle / kFinest > kImpulseFrom;
  e.level = 0;
  for (double steps = 1; e.level + 1 < kLevels && angle > kStepsFor * steps; steps *= 2)
    ++e.level;
}

/// A mass that is far from the body.
void TouchedBody::fly(Exciter& e) const noexcept {
  const double sample = step_s_[0], before = e.velocity_m_per_s;
  e.velocity_m_per_s =
      std::clamp(before + sample * e.outer_force_n * e.per_mass, -kFastest, kFastest);
  e.place_m += 0.5 * sample * (before + e.velocity_m_per_s);
  if (!(std::abs(e.place_m) < kFarthest)) {
    e.place_m = std::clamp(e.place_m, -kFarthest, kFarthest);
    e.velocity_m_per_s = 0;
  }
}

/// True if the exciter may touch within this sample. `look`: from where all is.
bool TouchedBody::look_at(std::size_t i, bool look) noexcept {
  Exciter& e = exciters_[i];
  if (e.kind == Exciter::Kind::kFriction) {
    e.near = e.normal_force_n > 0;
    if (!e.fresh)
      e.approach_m_per_s = e.mean_velocity_m_per_s = e.rubbing_m_per_s - surface_velocity(i);
    if (!e.near) {
      e.friction.release();
      e.last_force_n = 0;
    }
  } else {
    if (!e.fresh || look) {
      e.depth_m = e.place_m - surface(i);
      e.approach_m_per_s = e.velocity_m_per_s - surface_velocity(i);
      if (!e.fresh)
        e.mean_velocity_m_per_s = e.approach_m_per_s;
    }
    const double sample = step_s_[0];
    const double soon = e.approach_m_per_s + sample * e.outer_force_n * e.per_mass;
    e.near = e.impact.touching() || e.depth_m + kReach * sample * std::max(soon, 0.0) > 0;
    if (e.near)
      judge(e);
    else
      fly(e);
  }
  e.fresh = e.near;
  e.force_n = e.impulse_ns = e.dissipated_j = 0;
  return e.near;
}

/// Which exciters may touch within this sample, and how fine its steps must be.
void TouchedBody::look_around() noexcept {
  if (used_ > 1 && clock_ % kTidyEvery == 0)
    put_to_sleep();
  if (awake_changed_)
    list_awake();
  const bool look = clock_ % kLookEvery == 0;
  const std::size_t before = near_;
  bool same = true;
  near_ = 0;
  for (const std::size_t i : order_) {
    if (!look_at(i, look))
      continue;
    same = same && near_ < before && close_[near_] == i;
    if (near_ < close_.size())
      close_[near_] = i;
    else
      close_.push_back(i);
    ++near_;
  }
  close_.resize(near_);
  if (!pressed_.empty())
    look_at_pressed(look);
  if (!lone_awake_.empty() || !lone_near_.empty())
    look_at_lone(look);
  coupled_ = coupled_ && same && near_ == before;
  range_known_ = range_known_ && same && near_ == before;
  divided_ = divided_ && range_known_;
  foreseen_ = foreseen_ && near_ == 1 && clock_ % kTidyEvery != 0;
  if (!range_known_)
    find_range();
  in_place_ = one_range_ && !lone_touch();
  if (in_place_)
    choose_level();
}

void TouchedBody::look_at_lone(bool look) noexcept {
  lone_near_.clear();
  lone_at_ = {};
  for (const std::size_t i : lone_awake_)
    if (look_at(i, look)) {
      lone_near_.push_back(i);
      ++lone_at_[std::max(least_level_, exciters_[i].level)];
    }
}

/// How fine the steps must be of the one island, or of nothing.
void TouchedBody::choose_level() noexcept {
  std::size_t wanted = least_level_;
  for (const std::size_t i : close_)
    wanted = std::max(wanted, exciters_[i].level);
  if (near_ > 1)
    while (wanted > 0 && (work(near_, body_.modes()) << wanted) > kMaxWork)
      --wanted;
  quiet_ = wanted < level_ ? quiet_ + 1 : 0;
  if (wanted > level_ || (quiet_ > kPatience && (near_ == 0 || wanted + 1 < level_)) ||
      (near_ > 1 && wanted < level_))
    change_level(wanted);
}

void TouchedBody::change_level(std::size_t level) noexcept {
  if (level == level_)
    return;
  level_ = level;
  quiet_ = 0;
  coupled_ = false;
}

/// What the kernel needs of one place that is touched, for steps of these modes' length.
PlaceView TouchedBody::look_from(const ModesView& m, const double* shape,
                                 const PlaceArrays& into) noexcept {
  double answer = 0;
  for (std::size_t i = 0; i < m.padded; ++i) {
    into.push_real[i] = shape[i] * m.response_real[i];
    into.push_imaginary[i] = shape[i] * m.response_imaginary[i];
    // The mean velocity of the step after a state z is Re((mean_real - j mean_imaginary) z).
    const double real = shape[i] * m.mean_real[i], imaginary = shape[i] * m.mean_imaginary[i];
    answer += real * into.push_real[i] + imaginary * into.push_imaginary[i];
    // That of the step after the next: the same of P z.
    into.ahead_real[i] = real * m.turn_real[i] + imaginary * m.turn_imaginary[i];
    into.ahead_imaginary[i] = imaginary * m.turn_real[i] - real * m.turn_imaginary[i];
  }
  return {shape,           into.push_real,       into.push_imaginary,
          into.ahead_real, into.ahead_imaginary, answer};
}

void TouchedBody::focus(std::size_t slot) noexcept {
  place_view_ = look_from(view(), place_[slot].data() + range_first_, place_memory_.from(0));
  coupled_ = true;
  foreseen_ = false;
}

/// A sample of a contact that is the only one on these modes.
void TouchedBody::touch_alone(std::size_t slot, const ModesView& modes, const PlaceView& place,
                              Foresight& foresight, bool& foreseen, std::size_t level) noexcept {
  Exciter& e = exciters_[slot];
  if (!foreseen)
    foresight = kernel_->foresee(modes, place);
  foreseen = true;
  const bool strikes = e.kind == Exciter::Kind::kImpact;
  const double drive = strikes ? e.outer_force_n : e.rubbing_m_per_s, normal = e.normal_force_n;
  kernel_->touch(modes, place, foresight, e, {step_s_[level], level},
                 {&drive, &normal, nullptr, nullptr, nullptr, nullptr, 1});
}

/// A sample of modes that nothing touches.
void TouchedBody::ring(std::size_t first, std::size_t end) noexcept {
  if (first == end)
    return;
  if (has_outer_)
    kernel_->advance(view(0, first, end), outer_.data() + first, {});
  else
    kernel_->ring(view(0, first, end));
}

/// A sample of a body that nothing touches, and what is heard of it.
void TouchedBody::ring_alone() noexcept {
  forget_foresight();
  if (has_outer_ || ear_real_.empty())
    return ring(0, body_.padded());
  heard_m_per_s_ = kernel_->ring_heard(whole_, ear_real_[0].data(), ear_imaginary_[0].data());
  heard_known_ = true;
}

/// The contacts of the one island, on its range of modes.
void TouchedBody::touch_in_place() noexcept {
  sounds_ = true;
  if (near_ == 1 && !has_outer_) { // the general way knows of outer forces
    if (!coupled_)
      focus(close_[0]);
    touch_alone(close_[0], view(), place_view_, foresight_, foreseen_, level_);
    islands_foreseen_ = false;
  } else {
    system_.select_all();
    shapes_.clear();
    for (const std::size_t i : close_)
      shapes_.push_back(place_[i].data() + range_first_);
    const Group group{close_, view(), std::min(range_end_, body_.modes()) - range_first_,
                      has_outer_ ? outer_.data() + range_first_ : nullptr, level_};
    forget_foresight();
    if (!coupled_ || near_ == 1) {
      couple(group);
      packed_.clear(); // their coupling was in the same memory
    }
    coupled_ = near_ > 1; // one alone has place_view_
    touch_many(group);
  }
  ring(0, range_first_);
  ring(range_end_, body_.padded());
}

/// True while a sample needs nothing but its steps (look_around() would change nothing).
bool TouchedBody::steady(std::size_t slot) const noexcept {
  const Exciter& e = exciters_[slot];
  if (unsorted_ || used_ != 1 || near_ != 1 || close_[0] != slot || !e.fresh || !foreseen_ ||
      !coupled_ || has_outer_ || range_end_ - range_first_ != body_.padded() ||
      clock_ % kLookEvery == 0)
    return false;
  if (e.kind == Exciter::Kind::kFriction)
    return std::max(e.level, least_level_) == level_;
  return e.impact.touching() && std::max(e.level, least_level_) == level_ &&
         e.judged(0.5 * e.effective_mass_kg * e.approach_m_per_s * e.approach_m_per_s +
                  e.impact.stored_j());
}

/// How many samples from the first nothing stirs: the body is still and the exciter stays away.
std::size_t TouchedBody::rest(std::size_t slot, const Stretch& whole) noexcept {
  Exciter& e = exciters_[slot];
  if (sounds_ || near_ > 0 || unsorted_ || has_outer_ || used_ != 1 || level_ != least_level_)
    return 0;
  std::size_t n = 0;
  if (e.kind == Exciter::Kind::kImpact) {
    for (; n < whole.count && whole.drive[n] == 0 && e.velocity_m_per_s <= 0; ++n) {
      e.outer_force_n = 0;
      fly(e);
    }
  } else {
    for (; n < whole.count && !(whole.normal[n] > 0); ++n)
      rub(slot, whole.normal[n], whole.drive[n]);
  }
  std::fill_n(whole.heard, n, 0.0);
  std::fill_n(whole.force, n, 0.0);
  clock_ += n;
  return n;
}

void TouchedBody::run(std::size_t slot, const Stretch& whole) noexcept {
  if (slot >= exciters_.size() || ear_shape_.empty())
    return;
  Exciter& e = exciters_[slot];
  for (std::size_t n = 0; n < whole.count;) {
    const double normal = whole.normal ? whole.normal[n] : 0;
    const std::size_t still =
        rest(slot, {whole.drive + n, whole.normal ? whole.normal + n : nullptr, whole.heard + n,
                    whole.force + n, nullptr, nullptr, whole.count - n});
    if (still > 0) {
      n += still;
      continue;
    }
    if (steady(slot)) {
      const std::size_t room =
          std::min<std::size_t>(whole.count - n, kLookEvery - clock_ % kLookEvery);
      const std::size_t done = kernel_->touch(
          view(), place_view_, foresight_, e, {step_length(), level_},
          {whole.drive + n, whole.normal ? whole.normal + n : nullptr, whole.heard + n,
           whole.force + n, ear_real_[0].data(), ear_imaginary_[0].data(), room});
      if (done > 0) {
        quiet_ = 0;
        clock_ += done;
        n += done;
        look_back();
        continue;
      }
    }
    if (e.kind == Exciter::Kind::kFriction)
      rub(slot, normal, whole.drive[n]);
    else
      push_mass(slot, whole.drive[n]);
    step();
    whole.heard[n] = hear(0);
    whole.force[n] = force(slot);
    ++n;
  }
}

void TouchedBody::run_mass(std::size_t slot, std::span<const double> force_n,
                           std::span<double> heard, std::span<double> contact_n) noexcept {
  run(slot, {force_n.data(), nullptr, heard.data(), contact_n.data(), nullptr, nullptr,
             std::min({force_n.size(), heard.size(), contact_n.size()})});
}

void TouchedBody::run_rub(std::size_t slot, std::span<const double> velocity_m_per_s,
                          std::span<const double> normal_force_n, std::span<double> heard,
                          std::span<double> friction_n) noexcept {
  run(slot, {velocity_m_per_s.data(), normal_force_n.data(), heard.data(), friction_n.data(),
             nullptr, nullptr,
             std::min({velocity_m_per_s.size(), normal_force_n.size(), heard.size(),
                       friction_n.size()})});
}

void TouchedBody::step() noexcept {
  if (tied_ && moved_)
    look_for_difference();
  if (unsorted_)
    sort();
  heard_known_ = false;
  if (clock_ % kTidyEvery != 0 && all_sleep())
    quiet_ = 0;
  else
    look_around();
  ++clock_;
  if (!in_place_)
    touch_islands();
  else if (near_ > 0)
    touch_in_place();
  else if (sounds_)
    ring_alone();
  if (has_outer_) {
    outer_.clear();
    has_outer_ = false;
  }
  look_back();
}

/// After a sample: is everything still of this world?
void TouchedBody::look_back() noexcept {
  bool sane = true;
  const auto check = [&](std::size_t i) {
    Exciter& e = exciters_[i];
    sane =
        sane && std::abs(e.force_n) < kMostState && std::abs(e.mean_velocity_m_per_s) < kMostState;
    if (e.kind == Exciter::Kind::kImpact && !(std::abs(e.velocity_m_per_s) < kFastest)) {
      e.velocity_m_per_s = bounded(e.velocity_m_per_s, kFastest);
      e.fresh = false;
    }
  };
  for (const std::size_t i : close_)
    check(i);
  for (const std::size_t i : lone_near_)
    check(i);
  if (!sane)
    return reset();
  if (clock_ % kTidyEvery == 0 && sounds_) {
    heard_known_ = false;
    if (!body_.tidy())
      reset();
    else if (near_ == 0 && !lone_touch())
      sounds_ = body_.energy() > 0;
  }
}

} // namespace tactus::contact

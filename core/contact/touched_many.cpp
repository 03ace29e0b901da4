#include "core/contact/touched_body.hpp"

#include <algorithm>
#include <cmath>

/// Several contacts in one step: docs at TouchedBody.
namespace tactus::contact {
namespace {

constexpr double kLeastSlope = 1e-250; // N s/m; a contact softer than that has no force
constexpr int kKnockRounds = 8;

} // namespace

/// coupling_ = Y without the exciters' own masses, for those near, in columns.
void TouchedBody::couple() noexcept {
  for (std::size_t c = 0; c < near_; ++c) {
    double* const column = coupling_.data() + c * coupling_stride();
    std::fill_n(column, coupling_stride(), 0.0);
    for (std::size_t d = 0; d <= c; ++d)
      column[d] = coupling_[d * coupling_stride() + c] =
          kernel_->dot(place_[close_[c]].data(), place_[close_[d]].data(),
                       body_.level(level_).mobility.data(), body_.padded());
  }
  coupled_ = near_ > 1; // one alone has a PlaceView
}

void TouchedBody::touch_many() noexcept {
  const double h = step_length(), half = 0.5 * h;
  const ModesView modes = view(level_);
  sounds_ = true;
  foreseen_ = false;
  if (!coupled_ || near_ == 1)
    couple();
  const double* const outer = has_outer_ ? outer_.data() : nullptr;
  bool any_friction = false;
  for (std::size_t n = std::size_t{1} << level_; n-- > 0;) {
    knock_many();
    if (outer)
      kernel_->mean(modes, outer, {}, mean_.data());
    else
      kernel_->free_mean(modes, mean_.data());
    for (std::size_t c = 0; c < near_; ++c) {
      Exciter& e = exciters_[close_[c]];
      Term& t = terms_[c];
      const bool strikes = e.kind == Exciter::Kind::kImpact;
      t.own = strikes ? half * e.per_mass : 0;
      t.own_free = strikes ? e.velocity_m_per_s + t.own * e.outer_force_n : e.rubbing_m_per_s;
      t.free = t.own_free - kernel_->dot(place_[close_[c]].data(), mean_.data(), modes.padded);
      t.law = {};
      if (strikes) {
        if (Impact::meets(e.depth_m, e.approach_m_per_s, h))
          t.law = e.impact.enter_step(e.depth_m, e.approach_m_per_s, h);
      } else {
        any_friction = true;
        const double rate = expected(t.free - coupling_[c * coupling_stride() + c] * e.last_force_n,
                                     e.mean_velocity_m_per_s);
        e.friction.enter_step(e.normal_force_n, rate,
                              e.friction.law().roughness > 0 ? e.noise.normal() : 0.0, h);
        t.law = e.friction.stage().plain();
      }
    }
    solve();
    if (any_friction) {
      for (std::size_t c = 0; c < near_; ++c) {
        Exciter& e = exciters_[close_[c]];
        if (e.kind != Exciter::Kind::kFriction)
          continue;
        e.friction.refine(terms_[c].mean);
        terms_[c].law = e.friction.stage().plain();
      }
      solve();
    }
    pushes_.clear();
    for (const std::size_t c : acting_)
      pushes_.push_back({place_[close_[c]].data(), terms_[c].force});
    if (acting_.size() < near_) // the others' velocities follow from the modes'
      kernel_->mean(modes, outer, pushes_, mean_.data());
    kernel_->advance(modes, outer, pushes_);
    for (std::size_t c = 0; c < near_; ++c)
      leave(c, h);
  }
  for (const std::size_t i : close_)
    exciters_[i].force_n = exciters_[i].impulse_ns * body_.sample_rate();
}

/// What a step has done to an exciter.
void TouchedBody::leave(std::size_t c, double h) noexcept {
  Exciter& e = exciters_[close_[c]];
  Term& t = terms_[c];
  if (!t.acts) {
    t.force = 0;
    t.mean = t.own_free - kernel_->dot(place_[close_[c]].data(), mean_.data(), body_.padded());
  }
  e.approach_m_per_s = continued(t.mean, e.mean_velocity_m_per_s);
  e.mean_velocity_m_per_s = t.mean;
  e.impulse_ns += h * t.force;
  if (e.kind == Exciter::Kind::kFriction) {
    const double stored = e.friction.stored_j();
    e.friction.pass_step(t.mean);
    e.last_force_n = t.force;
    e.dissipated_j += h * t.force * t.mean + (stored - e.friction.stored_j());
    return;
  }
  if (t.acts)
    e.impact.pass_step(t.mean, h);
  const double own_mean = t.own_free - t.own * t.force, before = e.depth_m;
  e.place_m += h * own_mean;
  e.velocity_m_per_s = 2 * own_mean - e.velocity_m_per_s;
  e.depth_m += h * t.mean;
  e.impact.leave_step(e.depth_m);
  e.book(before, e.depth_m, t.force, h);
}

void TouchedBody::solve() noexcept {
  for (std::size_t c = 0; c < near_; ++c)
    terms_[c].acts = terms_[c].law.slope_ns_per_m > kLeastSlope;
  // Every round takes out at least one: it ends.
  for (bool pulls = true; pulls;) {
    acting_.clear();
    for (std::size_t c = 0; c < near_; ++c)
      if (terms_[c].acts)
        acting_.push_back(c);
    if (acting_.empty())
      return;
    if (acting_.size() <= body_.modes())
      solve_by_contact();
    else
      solve_by_mode();
    pulls = false;
    for (const std::size_t c : acting_)
      if (terms_[c].force < 0 && exciters_[close_[c]].kind == Exciter::Kind::kImpact) {
        terms_[c].acts = false;
        pulls = true;
      }
  }
}

void TouchedBody::solve_one() noexcept {
  Term& t = terms_[acting_[0]];
  const double y = coupling_[acting_[0] * coupling_stride() + acting_[0]] + t.own;
  const double under = 1 / (1 + t.law.slope_ns_per_m * y);
  t.mean = (t.free - y * t.law.offset_n) * under;
  t.force = (t.law.offset_n + t.law.slope_ns_per_m * t.free) * under;
}

/// Two by elimination; the pivots are those of solve_by_contact(), 1 and above.
void TouchedBody::solve_two() noexcept {
  Term &a = terms_[acting_[0]], &b = terms_[acting_[1]];
  const double* const column = coupling_.data() + acting_[0] * coupling_stride();
  const double* const other = coupling_.data() + acting_[1] * coupling_stride();
  const double y = column[acting_[1]], ya = column[acting_[0]] + a.own,
               yb = other[acting_[1]] + b.own;
  const double sa = a.law.slope_ns_per_m, sb = b.law.slope_ns_per_m;
  const double fa = a.law.offset_n, fb = b.law.offset_n;
  const double va = a.free - (ya * fa + y * fb), vb = b.free - (y * fa + yb * fb);
  const double pa = fa + sa * a.free, pb = fb + sb * b.free;
  const double first = 1 / (1 + sa * ya);
  const double second = 1 / (1 + sb * yb - sa * sb * y * y * first);
  b.mean = (vb - y * sa * first * va) * second;
  a.mean = (va - y * sb * b.mean) * first;
  b.force = (pb - y * sb * first * pa) * second;
  a.force = (pa - y * sa * b.force) * first;
}

/// With S = sqrt(slopes): (1 + S Y S) S v = S (free - Y offset) and the same matrix for the forces
/// over S, so that neither is a small difference of large numbers. Its eigenvalues are 1 and above.
void TouchedBody::solve_by_contact() noexcept {
  if (acting_.size() == 1)
    return solve_one();
  if (acting_.size() == 2)
    return solve_two();
  const std::size_t count = acting_.size(), stride = whole_lanes(count);
  const DenseView matrix{matrix_.data(), count, stride};
  double *const root = root_.data(), *const answer = answers_.data();
  std::fill_n(root, stride, 0.0);
  std::fill_n(answer, stride, 0.0);
  for (std::size_t i = 0; i < count; ++i)
    root[i] = std::sqrt(terms_[acting_[i]].law.slope_ns_per_m);
  for (std::size_t j = 0; j < count; ++j) {
    const Term& t = terms_[acting_[j]];
    const double* column = coupling_.data() + acting_[j] * coupling_stride();
    if (count < near_) { // those that act, without the others
      for (std::size_t i = 0; i < count; ++i)
        column_[i] = column[acting_[i]];
      column = column_.data();
    }
    dense_->take_column(matrix.at + j * stride, answer, column, root, root[j], t.law.offset_n,
                        stride);
    matrix(j, j) += 1 + t.law.slope_ns_per_m * t.own;
    answer[j] += t.own * t.law.offset_n;
  }
  std::fill_n(right_.data(), stride, 0.0);
  std::fill_n(other_.data(), stride, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const Term& t = terms_[acting_[i]];
    right_[i] = root[i] * (t.free - answer[i]);
    other_[i] = t.law.offset_n / root[i] + root[i] * t.free;
  }
  dense_->factorise(matrix);
  dense_->substitute(matrix, right_.data(), other_.data());
  for (std::size_t i = 0; i < count; ++i) {
    Term& t = terms_[acting_[i]];
    t.mean = right_[i] / root[i];
    t.force = root[i] * other_[i];
  }
}

/// With more contacts than modes. Each contact is eliminated, F = (offset + slope (free - g.d)) /
/// (1 + slope own), d the change of the modes' mean velocities, which remain:
/// d/y + sum g kappa (g.d) = sum g (offset + slope free)/(1 + slope own), y a mode's mobility.
void TouchedBody::solve_by_mode() noexcept {
  const std::size_t count = body_.modes(), stride = body_.padded();
  const ModeArray& mobility = body_.level(level_).mobility;
  const DenseView matrix{matrix_.data(), count, stride};
  std::fill_n(matrix_.data(), count * stride, 0.0);
  std::fill_n(right_.data(), stride, 0.0);
  std::fill_n(other_.data(), stride, 0.0);
  for (std::size_t i = 0; i < count; ++i)
    matrix(i, i) = mobility[i] > 0 ? 1 / mobility[i] : 1;
  for (const std::size_t c : acting_) {
    const Term& t = terms_[c];
    const double* shape = place_[close_[c]].data();
    const double over = 1 / (1 + t.law.slope_ns_per_m * t.own);
    kernel_->add(right_.data(), shape, over * (t.law.offset_n + t.law.slope_ns_per_m * t.free),
                 stride);
    dense_->add_square(matrix, shape, over * t.law.slope_ns_per_m);
  }
  dense_->factorise(matrix);
  dense_->substitute(matrix, right_.data(), other_.data());
  for (const std::size_t c : acting_) {
    Term& t = terms_[c];
    const double change = kernel_->dot(place_[close_[c]].data(), right_.data(), stride);
    const double over = 1 / (1 + t.law.slope_ns_per_m * t.own);
    t.force = over * (t.law.offset_n + t.law.slope_ns_per_m * (t.free - change));
    t.mean = over * (t.free - change - t.own * t.law.offset_n);
  }
}

/// Contacts too short for steps, all of one moment together. Each alone would get the impulse
/// J = (1 + e) rate/mobility; all at once get theta J, theta <= 1 the largest for which
/// dE = -theta J.v + theta^2 J.A J/2 is no gain, with the least restitution among them kept.
/// Rounds go on while some still approach.
void TouchedBody::knock_many() noexcept {
  const double h = step_length();
  const std::size_t padded = body_.padded();
  for (std::size_t c = 0; c < near_; ++c) { // these need the velocity at this moment
    Exciter& e = exciters_[close_[c]];
    if (e.kind == Exciter::Kind::kImpact && e.impulsive && !e.impact.touching())
      e.approach_m_per_s = e.velocity_m_per_s - surface_velocity(close_[c]);
  }
  for (int round = 0; round < kKnockRounds; ++round) {
    double work = 0, own = 0, least = 1;
    std::fill_n(mean_.data(), padded, 0.0);
    bool any = false;
    for (std::size_t c = 0; c < near_; ++c) {
      const Exciter& e = exciters_[close_[c]];
      Term& t = terms_[c];
      t.acts = e.kind == Exciter::Kind::kImpact && e.impulsive && !e.impact.touching() &&
               e.approach_m_per_s > 0 && Impact::meets(e.depth_m, e.approach_m_per_s, h);
      if (!t.acts)
        continue;
      const double kept = restitution(e.impact.law().dissipation_s_per_m * e.approach_m_per_s);
      t.force = (1 + kept) * e.approach_m_per_s / e.quick_mobility;
      work += t.force * e.approach_m_per_s;
      own += t.force * t.force * e.per_mass;
      least = std::min(least, kept);
      kernel_->add(mean_.data(), place_[close_[c]].data(), t.force, padded);
      any = true;
    }
    if (!any)
      return;
    const double answer = own + kernel_->dot(mean_.data(), mean_.data(), padded);
    const double theta = std::min(1.0, (1 + least) * work / answer);
    kernel_->add(body_.real.data(), mean_.data(), theta, padded);
    for (std::size_t c = 0; c < near_; ++c) {
      Exciter& e = exciters_[close_[c]];
      if (terms_[c].acts) {
        const double impulse = theta * terms_[c].force;
        e.velocity_m_per_s -= impulse * e.per_mass;
        e.impulse_ns += impulse;
        e.book_impulse(impulse, h);
      }
    }
    for (std::size_t c = 0; c < near_; ++c) {
      Exciter& e = exciters_[close_[c]];
      const bool strikes = e.kind == Exciter::Kind::kImpact;
      e.approach_m_per_s =
          (strikes ? e.velocity_m_per_s : e.rubbing_m_per_s) - surface_velocity(close_[c]);
      e.mean_velocity_m_per_s = e.approach_m_per_s;
    }
  }
}

} // namespace tactus::contact

#include "core/contact/touched_body.hpp"

#include <algorithm>
#include <cmath>

/// Several contacts in one step: docs at TouchedBody.
namespace tactus::contact {
namespace {

constexpr double kLeastSlope = 1e-250; // N s/m; a contact softer than that has no force
constexpr int kKnockRounds = 8;

/// Cholesky's factorisation of a symmetric positive definite matrix, rows of `count`, lower half.
void factorise(double* matrix, std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    double* row = matrix + i * count;
    for (std::size_t j = 0; j <= i; ++j) {
      const double* above = matrix + j * count;
      double sum = row[j];
      for (std::size_t k = 0; k < j; ++k)
        sum -= row[k] * above[k];
      row[j] = j < i ? sum / above[j] : std::sqrt(std::max(sum, 1e-300));
    }
  }
}

/// Solves with that factorisation, in place.
void substitute(const double* matrix, std::size_t count, double* x) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    double sum = x[i];
    for (std::size_t k = 0; k < i; ++k)
      sum -= matrix[i * count + k] * x[k];
    x[i] = sum / matrix[i * count + i];
  }
  for (std::size_t i = count; i-- > 0;) {
    double sum = x[i];
    for (std::size_t k = i + 1; k < count; ++k)
      sum -= matrix[k * count + i] * x[k];
    x[i] = sum / matrix[i * count + i];
  }
}

} // namespace

/// coupling_[c][d] = Y without the exciters' own masses, for those near.
void TouchedBody::couple() noexcept {
  for (std::size_t c = 0; c < near_; ++c)
    for (std::size_t d = 0; d <= c; ++d)
      coupling_[c * near_ + d] = coupling_[d * near_ + c] =
          kernel_->dot(place_[close_[c]].data(), place_[close_[d]].data(),
                       body_.level(level_).mobility.data(), body_.padded());
  coupled_ = near_ > 1; // one alone has a PlaceView
}

void TouchedBody::touch_many() noexcept {
  const double h = step_length(), half = 0.5 * h;
  const ModesView modes = view(level_);
  sounds_ = true;
  foreseen_ = false;
  if (!coupled_ || near_ == 1)
    couple();
  bool any_friction = false;
  for (std::size_t n = std::size_t{1} << level_; n-- > 0;) {
    knock_many();
    kernel_->free_mean(modes, outer_.data(), mean_.data());
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
        const double rate =
            expected(t.free - coupling_[c * near_ + c] * e.last_force_n, e.mean_velocity_m_per_s);
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
    std::copy_n(outer_.data(), modes.padded, drive_.data());
    for (const std::size_t c : acting_)
      kernel_->add(drive_.data(), place_[close_[c]].data(), terms_[c].force, modes.padded);
    if (acting_.size() < near_) // the others' velocities follow from the modes'
      kernel_->free_mean(modes, drive_.data(), mean_.data());
    kernel_->advance(modes, drive_.data());
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

/// With S = sqrt(slopes): (1 + S Y S) S v = S (free - Y offset) and the same matrix for the forces
/// over S, so that neither is a small difference of large numbers. Its eigenvalues are 1 and above.
void TouchedBody::solve_by_contact() noexcept {
  const std::size_t count = acting_.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Term& t = terms_[acting_[i]];
    const double root = std::sqrt(t.law.slope_ns_per_m);
    double answer = t.own * t.law.offset_n;
    for (std::size_t j = 0; j < count; ++j) {
      const Term& other = terms_[acting_[j]];
      double y = coupling_[acting_[i] * near_ + acting_[j]];
      answer += y * other.law.offset_n;
      if (j > i)
        continue;
      if (j == i)
        y += t.own;
      matrix_[i * count + j] =
          (i == j ? 1.0 : 0.0) + root * std::sqrt(other.law.slope_ns_per_m) * y;
    }
    right_[i] = root * (t.free - answer);
    other_[i] = t.law.offset_n / root + root * t.free;
  }
  factorise(matrix_.data(), count);
  substitute(matrix_.data(), count, right_.data());
  substitute(matrix_.data(), count, other_.data());
  for (std::size_t i = 0; i < count; ++i) {
    Term& t = terms_[acting_[i]];
    const double root = std::sqrt(t.law.slope_ns_per_m);
    t.mean = right_[i] / root;
    t.force = root * other_[i];
  }
}

/// With more contacts than modes. Each contact is eliminated, F = (offset + slope (free - g.d)) /
/// (1 + slope own), d the change of the modes' mean velocities, which remain:
/// d/y + sum g kappa (g.d) = sum g (offset + slope free)/(1 + slope own), y a mode's mobility.
void TouchedBody::solve_by_mode() noexcept {
  const std::size_t count = body_.modes();
  const ModeArray& mobility = body_.level(level_).mobility;
  std::fill_n(matrix_.data(), count * count, 0.0);
  std::fill_n(right_.data(), count, 0.0);
  for (std::size_t i = 0; i < count; ++i)
    matrix_[i * count + i] = mobility[i] > 0 ? 1 / mobility[i] : 1;
  for (const std::size_t c : acting_) {
    const Term& t = terms_[c];
    const double* shape = place_[close_[c]].data();
    const double over = 1 / (1 + t.law.slope_ns_per_m * t.own);
    const double drive = over * (t.law.offset_n + t.law.slope_ns_per_m * t.free);
    for (std::size_t i = 0; i < count; ++i) {
      const double stiff = over * t.law.slope_ns_per_m * shape[i];
      right_[i] += drive * shape[i];
      for (std::size_t j = 0; j <= i; ++j)
        matrix_[i * count + j] += stiff * shape[j];
    }
  }
  factorise(matrix_.data(), count);
  substitute(matrix_.data(), count, right_.data());
  for (const std::size_t c : acting_) {
    Term& t = terms_[c];
    const double* shape = place_[close_[c]].data();
    double change = 0;
    for (std::size_t i = 0; i < count; ++i)
      change += shape[i] * right_[i];
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

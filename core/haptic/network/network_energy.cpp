#include "core/dsp/elementary.hpp"
#include "core/haptic/network/network_model.hpp"

#include <algorithm>
#include <cmath>

/// NetworkModel's energy and its limit.
namespace tactus::haptic {
namespace {
// Losses that last longer are final; shorter dips of the energy are an error of the scheme.
constexpr double kBudgetTimeConstant_s = 0.05;
constexpr double kRounding = 1e-9; // share of the elastic and kinetic energy
} // namespace

/// v^T M v/2, for each link with the vector d and length L at the steps n and n + 1
///   k/2 (d_n . d_(n+1) - l0 (L_n + L_(n+1)) + l0^2),
/// and for gravity -m g . (x_n + x_(n+1))/2, where x_n = x_(n+1) - h v. The scheme conserves the
/// sum for links that keep their direction or have no rest length.
double NetworkModel::energy_j() const noexcept {
  if (!network_)
    return 0;
  const double h = step_s_;
  double energy = handle_energy_j();
  for (std::size_t i = 0; i < count_; ++i)
    if (inverse_mass_[i] > 0) {
      const Vec3 v = velocity(i);
      energy += mass_[i] * (0.5 * dot(v, v) - dot(network_->gravity, position(i) - v * (0.5 * h)));
    }
  for (const NetworkLink& link : network_->links) {
    const Vec3 now = position(link.b) - position(link.a);
    const Vec3 before = now - (velocity(link.b) - velocity(link.a)) * h;
    const double l0 = link.rest_length_m;
    const double half = 0.5 * link.stiffness_n_per_m;
    if (link.kind == NetworkLink::Kind::kSpring && l0 == 0) {
      energy += half * dot(now, before);
      continue;
    }
    const double length = std::sqrt(dot(now, now)), length_before = std::sqrt(dot(before, before));
    const auto is_loaded = [&link, l0](double l) {
      return link.kind == NetworkLink::Kind::kSpring ||
             (link.kind == NetworkLink::Kind::kPull ? l > l0 : l < l0);
    };
    if (is_loaded(length) && is_loaded(length_before))
      energy += half * (dot(now, before) - l0 * (length + length_before) + l0 * l0);
  }
  return energy;
}

/// Energy of a spring of the handle: k/2 e_n . e_(n+1), and F |e| - F^2/(2k) where its force is
/// limited to F. product: e_n . e_(n+1); extent: |e|.
double NetworkModel::saturated_spring_energy_j(double stiffness, double product,
                                               double extent) noexcept {
  return stiffness * extent <= kMaxHandle_n
             ? 0.5 * stiffness * product
             : kMaxHandle_n * (extent - 0.5 * kMaxHandle_n / stiffness);
}

double NetworkModel::handle_energy_j() const noexcept {
  const double h = step_s_;
  const Vec3 handle_before = handle_ - handle_velocity_ * h;
  const NetworkTouch& touch = network_->touch;
  double energy = 0;
  for (std::size_t c = 0; c < candidate_count_; ++c) {
    const std::size_t i = candidates_[c];
    const Vec3 before = position(i) - velocity(i) * h;
    const double now = touch.radius_m - norm(position(i) - handle_);
    const double previous = touch.radius_m - norm(before - handle_before);
    if (now > 0 && previous > 0)
      energy +=
          saturated_spring_energy_j(touch_gain_[i] * touch.stiffness_n_per_m, now * previous, now);
  }
  if (grabbed_ != kNoKey) {
    const Vec3 now = handle_ - position(grabbed_mass_);
    const Vec3 previous = handle_before - (position(grabbed_mass_) - velocity(grabbed_mass_) * h);
    energy += saturated_spring_energy_j(grab_gain_ * network_->grab.stiffness_n_per_m,
                                        dot(now, previous), norm(now));
  }
  return energy;
}

/// F . (v- + v+)/2 h for each pluck.
double NetworkModel::work_of_plucks() const noexcept {
  double work = 0;
  for (const RunningPluck& pluck : plucks_)
    if (pluck.key != kNoKey)
      work += dot(pluck.force_n, pluck.velocity_before + velocity(pluck.mass));
  return 0.5 * step_s_ * work;
}

/// Enforces energy <= budget + work in every tick, so that the network never gives out more energy
/// than it got. Lost energy leaves the budget with the time constant kBudgetTimeConstant_s: the
/// error of the scheme oscillates within a period, and its rise must not count as a gain.
void NetworkModel::limit_energy(double work_j, double period_s) noexcept {
  const double energy = energy_j(), available = budget_j_ + work_j;
  double kinetic = 0;
  for (std::size_t i = 0; i < count_; ++i)
    if (inverse_mass_[i] > 0)
      kinetic += 0.5 * mass_[i] * dot(velocity(i), velocity(i));
  if (!std::isfinite(energy) || !std::isfinite(available)) {
    reset();
    return;
  }
  const double excess = energy - available;
  if (excess <= kRounding * (std::abs(energy) + kinetic)) {
    const double budget_decay = math::exp(-period_s / kBudgetTimeConstant_s);
    budget_j_ = std::min(available, energy + std::max(-excess, 0.0) * budget_decay);
    return;
  }
  ++energy_limited_ticks_;
  budget_j_ = available;
  const double scale = kinetic > excess ? std::sqrt((kinetic - excess) / kinetic) : 0.0;
  for (std::size_t i = 0; i < count_; ++i)
    vx_[i] *= scale, vy_[i] *= scale, vz_[i] *= scale;
}

} // namespace tactus::haptic

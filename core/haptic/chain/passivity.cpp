#include "core/haptic/chain/passivity.hpp"

#include <cmath>

namespace tactus::haptic {
namespace {

constexpr double kMaxEnergy_j = 1e6;
// The handle is at rest while it stays within the reading's error plus this distance.
constexpr double kAtRestRadius_m = 2e-5;
// c of the bound c K T: six times what a spring without latency creates. The rest removes energy
// that has already been created, and covers an undeclared latency of two ticks.
constexpr double kDampingPerLeak = 3;
constexpr double kStiffnessTimeConstant_s = 0.05;
constexpr double kVelocityWindow_s = 2e-3;
// Below this speed the velocity's direction is noise.
constexpr double kMinBrakedSpeed_m_per_s = 1e-4;
// A bounce lasts pi sqrt(M/K), 70 ms for 0.1 kg on 200 N/m; a handle that stays in contact longer
// is held there, and swings against the hand.
constexpr double kMaxBounce_s = 0.1;

/// The value with its magnitude reduced by that much, not below zero.
double shortened(double value, double by) noexcept {
  return std::copysign(std::max(std::abs(value) - by, 0.0), value);
}

} // namespace

void PassivityController::observe(const PassivitySettings& settings, const Vec3& position_m,
                                  const Vec3& written_n, double allowance_j) noexcept {
  if (!started_) {
    started_ = true;
    positions_.fill(position_m);
    rest_position_ = position_m;
  }
  const Vec3 moved = position_m - at(positions_, tick_);
  ++tick_;
  at(positions_, tick_) = position_m;
  at(forces_, tick_) = written_n;
  const auto latency =
      static_cast<std::size_t>(std::clamp(settings.latency_ticks, 0, kMaxLatency_ticks));
  const Vec3& felt = at(forces_, tick_ + kHistory - latency);
  energy_j_ =
      std::clamp(energy_j_ - dot(felt, moved) + allowance_j, -kMaxEnergy_j, settings.tank_j);
  position_changes_ += dot(moved, moved);

  if (norm(position_m - rest_position_) > 2.0 * settings.position_noise_m + kAtRestRadius_m) {
    rest_position_ = position_m;
    at_rest_s_ = 0;
  } else {
    at_rest_s_ += settings.period_s;
  }
  if (at_rest_s_ >= kAtRest_s)
    energy_j_ = std::max(energy_j_, 0.0);
}

/// Displacement of the handle over the last kVelocityWindow_s beyond the reading's error, m.
Vec3 PassivityController::displacement(const PassivitySettings& settings) noexcept {
  const double ticks = std::clamp(std::floor(kVelocityWindow_s / settings.period_s + 0.5), 1.0,
                                  static_cast<double>(kHistory - 1));
  const Vec3 moved =
      at(positions_, tick_) - at(positions_, tick_ + kHistory - static_cast<std::size_t>(ticks));
  const double noise = settings.position_noise_m;
  return {shortened(moved.x, noise), shortened(moved.y, noise), shortened(moved.z, noise)};
}

/// Stiffness of the rendered world at the handle, N/m: sqrt(sum dF^2 / sum dx^2), both sums leaky
/// with kStiffnessTimeConstant_s. Exact for a spring, whatever the encoder's step.
double PassivityController::stiffness(const PassivitySettings& settings,
                                      const Vec3& desired_n) noexcept {
  const Vec3 change = desired_n - desired_;
  desired_ = desired_n;
  force_changes_ += dot(change, change);
  const double result =
      position_changes_ > 0.0 ? std::sqrt(force_changes_ / position_changes_) : 0.0;
  const double decay = std::exp(-settings.period_s / kStiffnessTimeConstant_s);
  force_changes_ *= decay;
  position_changes_ *= decay;
  return std::isfinite(result) ? result : 0.0;
}

/// How much to subtract from the contact's force, N, so that a handle thrown back gets no more
/// energy than the observer holds. Speeds along that force: `outward` confirmed by the
/// displacement, `reading` as read.
double PassivityController::release_cut(const PassivitySettings& settings, double contact_n,
                                        double outward, double reading) noexcept {
  const double T = settings.period_s;
  const double accelerated = std::max(outward - outward_, 0.0); // in one tick
  outward_ = outward;
  contact_s_ = contact_n > 0.0 ? contact_s_ + T : 0.0;
  const int latency = std::clamp(settings.latency_ticks, 0, kMaxLatency_ticks);
  const double error = settings.position_noise_m / kVelocityWindow_s; // of a speed, m/s
  if (!(contact_n > 0.0) || contact_s_ > kMaxBounce_s ||
      !(outward > kMinBrakedSpeed_m_per_s + error))
    return 0.0;
  // The speed when this force acts, and the energy left after the forces still in transit.
  const double now = error > 0.0 ? outward + 2.0 * error : std::max(outward, reading);
  const double speed = now + accelerated * latency;
  double left_j = energy_j_;
  for (int k = latency - 1, ahead = 1; k >= 0; --k, ++ahead)
    left_j -= norm(at(forces_, tick_ + kHistory - static_cast<std::size_t>(k))) *
              (now + accelerated * ahead) * T;
  // A force F releases the energy speed (F T + F^2 / (2 slew)) while it is held for T and then
  // falls at the slew limit. The handle accelerates meanwhile: in the mean over a force that falls
  // to zero by a quarter of what the present acceleration would give.
  const double slew = std::max(settings.slew_n_per_s, 1e-6);
  const double mean_speed = speed + 0.25 * accelerated * contact_n / (slew * T);
  const double affordable_n =
      slew * (std::sqrt(T * T + 2.0 * std::max(left_j, 0.0) / (slew * mean_speed)) - T);
  return std::max(contact_n - affordable_n, 0.0);
}

Vec3 PassivityController::limit(const PassivitySettings& settings, const Vec3& desired_n,
                                const Vec3& contact_n, const Vec3& velocity) noexcept {
  const double T = settings.period_s;
  const double stiffness_n_per_m = stiffness(settings, desired_n);
  // The bound is the last displacement over one tick. Its mean velocity as the bound would be too
  // slow by half and more for single encoder steps and for a handle that a wall throws back:
  // bench_haptic_passivity then finds twice as many flights that gain energy.
  const Vec3 fastest = displacement(settings) * (1.0 / T);
  Vec3 agreed;
  for (int axis = 0; axis < 3; ++axis)
    if (fastest[axis] * velocity[axis] > 0.0)
      agreed[axis] = std::copysign(std::min(std::abs(fastest[axis]), std::abs(velocity[axis])),
                                   velocity[axis]);
  Vec3 force = desired_n;
  acted_ = false;

  const double contact = norm(contact_n);
  const Vec3 outwards = contact > 0.0 ? contact_n * (1.0 / contact) : Vec3{};
  const double cut = release_cut(settings, contact, dot(agreed, outwards), dot(velocity, outwards));
  if (cut > 0.0) {
    force -= outwards * cut;
    acted_ = true;
  }
  // The energy is created along the force; a damper across it would only add force. While the force
  // is zero the direction of the last one is used.
  if (const double length = norm(desired_n); length > 0.0)
    direction_ = desired_n * (1.0 / length);
  const Vec3 along = direction_ * dot(agreed, direction_);
  const double speed = norm(along);
  const double limit = settings.damping_limit_n_s_per_m * std::min(1.0, 1e-3 / T);
  // One encoder step shows as an energy of K q^2/2 that the world has not created.
  const double step = 2.0 * settings.position_noise_m;
  const double debt_j = -energy_j_ - 0.5 * std::min(stiffness_n_per_m, limit / T) * step * step;
  if (debt_j > 0.0 && speed > kMinBrakedSpeed_m_per_s) {
    const double damping =
        std::min({limit, kDampingPerLeak * stiffness_n_per_m * T, debt_j / (T * speed * speed)});
    force -= along * damping;
    acted_ = true;
  }
  return force;
}

} // namespace tactus::haptic

#include "core/haptic/chain/passivity.hpp"

#include "core/dsp/elementary.hpp"

#include <cmath>
#include <limits>

namespace tactus::haptic {
namespace {

constexpr double kMaxEnergy_j = 1e6;
// The handle is at rest while it stays within the reading's error plus this distance.
constexpr double kAtRestRadius_m = 2e-5;
// Largest damping, in units of K T, beyond the damping that the present creation of energy needs.
// This excess removes energy created earlier.
constexpr double kDampingPerLeak = 3;
constexpr double kMinForce_n = 1e-12; // a smaller force is rounding
constexpr double kStiffnessTimeConstant_s = 0.05;
// A host that answers every few ticks changes its force some ticks after the motion.
constexpr double kChangeTimeConstant_s = 0.004;
// Squared correlation of force and motion from which a force counts as a spring.
constexpr double kMinCoherence = 0.25;
constexpr double kVelocityWindow_s = 2e-3;
constexpr double kApproachWindow_s = 0.032;
// Below this speed the velocity's direction is noise.
constexpr double kMinBrakedSpeed_m_per_s = 1e-4;
// A bounce lasts pi sqrt(M/K), 70 ms for 0.1 kg on 200 N/m. A handle that stays in contact longer
// is pressed on by the hand and oscillates against it.
constexpr double kMaxBounce_s = 0.1;
// Share of the approach by which the contact must have slowed the handle before its mass can be
// estimated from the motion.
constexpr double kMinSlowing = 0.02;

/// The value with its magnitude reduced by `by`, but not below zero.
double shortened(double value, double by) noexcept {
  return std::copysign(std::max(std::abs(value) - by, 0.0), value);
}

double window_ticks(double seconds, double period_s, std::size_t most) noexcept {
  return std::clamp(std::floor(seconds / period_s + 0.5), 1.0, static_cast<double>(most));
}

int latency_of(const PassivitySettings& settings) noexcept {
  return std::clamp(settings.latency_ticks, 0, PassivityController::kMaxLatency_ticks);
}

} // namespace

void PassivityController::observe(const PassivitySettings& settings, const Vec3& position_m,
                                  const Vec3& written_n) noexcept {
  if (!started_) {
    started_ = true;
    positions_.fill(position_m);
    rest_position_ = position_m;
  }
  moved_before_ = moved_;
  moved_ = position_m - at(positions_, tick_);
  // The contact's part of the written force, after the slew limit: along the contact's direction,
  // and no longer than the contact force is now or was before.
  const Vec3& last = at(contacts_, tick_);
  const double longest = std::max(norm(contact_.returned), norm(last));
  const Vec3 felt =
      contact_.direction *
      std::clamp(dot(written_n - command_.returned, contact_.direction), 0.0, longest);
  variation_n_ += norm(felt - last);
  contact_.created_j += dot(felt - contact_.returned, moved_);
  ++tick_;
  at(positions_, tick_) = position_m;
  at(contacts_, tick_) = felt;
  const auto latency = static_cast<std::size_t>(latency_of(settings));
  energy_j_ = std::clamp(energy_j_ - dot(at(contacts_, tick_ + kHistory - latency), moved_),
                         -kMaxEnergy_j, settings.tank_j);

  if (norm(position_m - rest_position_) > 2.0 * settings.position_noise_m + kAtRestRadius_m) {
    rest_position_ = position_m;
    at_rest_s_ = 0;
  } else {
    at_rest_s_ += settings.period_s;
  }
  if (at_rest_s_ >= kAtRest_s) { // friction and hand have dissipated the energy
    energy_j_ = std::max(energy_j_, 0.0);
    contact_.created_j = command_.created_j = 0;
  }
}

/// Displacement of the handle over the last kVelocityWindow_s beyond the reading's error, m.
Vec3 PassivityController::displacement(const PassivitySettings& settings) noexcept {
  const double ticks = window_ticks(kVelocityWindow_s, settings.period_s, 15);
  const Vec3 moved =
      at(positions_, tick_) - at(positions_, tick_ + kHistory - static_cast<std::size_t>(ticks));
  const double noise = settings.position_noise_m;
  return {shortened(moved.x, noise), shortened(moved.y, noise), shortened(moved.z, noise)};
}

/// Stiffness of this part of the force along its direction, N/m: -sum dF dx / sum dx^2. Exact for a
/// spring, whatever the encoder's step; zero for a force that does not follow the motion.
double PassivityController::Held::stiffness(double period_s, const Vec3& force_n,
                                            const Vec3& moved_m) noexcept {
  const bool begins = desired == Vec3{};
  const double part = 1.0 - math::exp(-period_s / kChangeTimeConstant_s);
  force_change_n += part * ((begins ? 0.0 : dot(force_n - desired, direction)) - force_change_n);
  motion_m += part * ((begins ? 0.0 : dot(moved_m, direction)) - motion_m);
  const double decay = math::exp(-period_s / kStiffnessTimeConstant_s);
  changes_n2 = decay * changes_n2 + force_change_n * force_change_n;
  product_nm = decay * product_nm - force_change_n * motion_m;
  motions_m2 = decay * motions_m2 + motion_m * motion_m;
  const bool is_spring = motions_m2 > 0.0 && product_nm > 0.0 &&
                         product_nm * product_nm > kMinCoherence * changes_n2 * motions_m2;
  const double result = is_spring ? product_nm / motions_m2 : 0.0;
  return std::isfinite(result) ? result : 0.0;
}

void PassivityController::Held::brake(const PassivitySettings& settings, const Vec3& force_n,
                                      const Vec3& moved_m, const Vec3& velocity, double lead_ticks,
                                      double allowance_w) noexcept {
  const double T = settings.period_s, length = norm(force_n);
  if (!(length > kMinForce_n)) {
    *this = {.direction = direction};
    return;
  }
  direction = force_n * (1.0 / length);
  const double stiffness_n_per_m = stiffness(T, force_n, moved_m);
  desired = returned = force_n;
  const double limit = settings.damping_limit_n_s_per_m * std::min(1.0, 1e-3 / T);
  const double speed = dot(velocity, direction);
  const double leak = stiffness_n_per_m * T * lead_ticks; // N s/m
  created_j = std::clamp(created_j + (leak * speed * speed - allowance_w) * T, 0.0, kMaxEnergy_j);
  // One encoder step appears as an energy of K q^2/2 that the force has not created.
  const double step = 2.0 * settings.position_noise_m;
  const double debt_j = created_j - 0.5 * std::min(stiffness_n_per_m, limit / T) * step * step;
  if (!settings.active || !(debt_j > 0.0) || !(std::abs(speed) > kMinBrakedSpeed_m_per_s))
    return;
  const double damping = std::min(
      {limit, kDampingPerLeak * stiffness_n_per_m * T + leak, debt_j / (T * speed * speed)});
  const double cut = std::min(damping * speed, length);
  created_j -= cut * speed * T;
  returned = force_n * (1.0 - cut / length);
}

void PassivityController::begin_contact(const PassivitySettings& settings) noexcept {
  const double T = settings.period_s;
  const auto window = static_cast<std::size_t>(window_ticks(kApproachWindow_s, T, kHistory - 2));
  const std::size_t ticks = std::min(free_ticks_, window);
  const double seconds = static_cast<double>(ticks) * T;
  arrival_m_ = at(positions_, tick_ - 1);
  approach_ = ticks > 0
                  ? (arrival_m_ - at(positions_, tick_ + kHistory - 1 - ticks)) * (1.0 / seconds)
                  : Vec3{};
  approach_error_ = ticks > 0 ? 2.0 * settings.position_noise_m / seconds : 0.0;
}

/// Closes the account of a contact when its last force has reached the hand.
void PassivityController::end_contact(const PassivitySettings& settings) noexcept {
  contact_s_ = impulse_ns_ = double_impulse_kg_m_ = variation_n_ = 0;
  free_ticks_ = std::min(free_ticks_ + 1, kHistory);
  const bool in_transit = free_ticks_ <= static_cast<std::size_t>(latency_of(settings)) ||
                          at(contacts_, tick_) != Vec3{};
  energy_j_ = in_transit ? std::min(energy_j_, 0.0) : 0.0;
}

/// The largest force (N) that the contact may exert from now on, on a handle that it throws back.
/// `outward`: speed of the handle along that force; `accelerated`: growth of this speed in the last
/// tick.
///
/// A force F that is held for T and then falls at the slew limit s is an impulse F T + F^2/(2 s).
/// It is bounded by momentum and by energy. The larger bound holds, because a hand that has pressed
/// during the contact has supplied energy.
/// - Momentum: a free handle of mass M that arrives at the speed v leaves with at most v as long as
///   the impulse of the whole contact is at most 2 M v. The mass is estimated from the motion so
///   far as M = double impulse / (v t - depth), with the reading's error on the safe side.
/// - Energy: that impulse times the speed is at most the energy that the hand has put in, minus the
///   energy of the forces in transit and the error that the readings may have added.
double PassivityController::affordable_force(const PassivitySettings& settings, double outward,
                                             double accelerated) noexcept {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  const double T = settings.period_s, slew = std::max(settings.slew_n_per_s, 1e-6);
  const double noise = settings.position_noise_m;
  const int latency = latency_of(settings);
  const auto felt = [&](int ago) {
    return norm(at(contacts_, tick_ + kHistory - static_cast<std::size_t>(ago)));
  };
  double_impulse_kg_m_ += (impulse_ns_ + 0.5 * felt(latency) * T) * T;
  impulse_ns_ += felt(latency) * T;
  double in_transit_ns = 0;
  for (int ago = 0; ago < latency; ++ago)
    in_transit_ns += felt(ago) * T;
  const auto force_of = [&](double impulse_ns) {
    return slew * (std::sqrt(T * T + 2.0 * std::max(impulse_ns, 0.0) / slew) - T);
  };

  double by_momentum = 0, speed = 0;
  const double arrival = -dot(approach_, contact_.direction);
  if (arrival > approach_error_) {
    const double slowed_m =
        dot(at(positions_, tick_) - arrival_m_, contact_.direction) + arrival * contact_s_;
    if (!(slowed_m > kMinSlowing * arrival * contact_s_))
      return kAny; // still approaching
    const double mass = double_impulse_kg_m_ / (slowed_m + 2.0 * noise);
    by_momentum = force_of(mass * (2.0 * arrival - approach_error_) - impulse_ns_ - in_transit_ns);
    if (mass > 0.0)
      speed = (impulse_ns_ + in_transit_ns) / mass - arrival;
  }
  if (const double error = noise / kVelocityWindow_s; outward > kMinBrakedSpeed_m_per_s + error)
    speed = std::max(speed, outward + 2.0 * error + accelerated * latency);
  if (!(speed > 0.0))
    return kAny;
  const double left_j = energy_j_ - noise * variation_n_ - in_transit_ns * speed;
  // The handle accelerates meanwhile. Averaged over a force that falls linearly to zero, this adds
  // a quarter of the speed that the present acceleration would give.
  const double mean_speed = speed + 0.25 * accelerated * norm(contact_.desired) / (slew * T);
  return std::max(by_momentum, force_of(left_j / mean_speed));
}

PassivityController::Parts PassivityController::limit(const PassivitySettings& settings,
                                                      const Parts& desired,
                                                      const Vec3& velocity) noexcept {
  const double T = settings.period_s;
  // Bounds the speed by the displacement of the last 2 ms divided by one tick. The mean speed of
  // these 2 ms would be too low by half or more, for single encoder steps and for a handle that a
  // wall throws back.
  const Vec3 fastest = displacement(settings) * (1.0 / T);
  Vec3 agreed;
  for (int axis = 0; axis < 3; ++axis)
    if (fastest[axis] * velocity[axis] > 0.0)
      agreed[axis] = std::copysign(std::min(std::abs(fastest[axis]), std::abs(velocity[axis])),
                                   velocity[axis]);
  const double latency = latency_of(settings);
  command_.brake(settings, desired.command, moved_before_, agreed, latency + 1.5,
                 settings.allowance_w);
  contact_.brake(settings, desired.contact, moved_, agreed, latency + 0.5, 0.0);

  if (contact_.desired == Vec3{}) {
    end_contact(settings);
  } else {
    if (contact_s_ == 0.0)
      begin_contact(settings);
    contact_s_ += T;
    free_ticks_ = 0;
  }
  const double agreed_outward = dot(agreed, contact_.direction);
  const double accelerated = std::max(agreed_outward - outward_, 0.0);
  outward_ = agreed_outward;
  if (contact_s_ > 0.0 && contact_s_ <= kMaxBounce_s) {
    // An exact reading above the speed of the last 2 ms is used, because the handle accelerates.
    const double outward = settings.position_noise_m > 0.0 || !(agreed_outward > 0.0)
                               ? agreed_outward
                               : std::max(agreed_outward, dot(velocity, contact_.direction));
    const double most = affordable_force(settings, outward, accelerated);
    if (settings.active && most < dot(contact_.returned, contact_.direction))
      contact_.returned = contact_.direction * most;
  }
  taken_n_ = norm(contact_.returned + command_.returned - desired.contact - desired.command);
  return {contact_.returned, command_.returned};
}

} // namespace tactus::haptic

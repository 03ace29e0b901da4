#include "core/haptic/network/network_model.hpp"
#include "core/haptic/network/stability.hpp"

#include <algorithm>
#include <cmath>

/// NetworkModel's steps within a servo tick.
namespace tactus::haptic {
namespace {
constexpr double kMinLength2_m2 = 1e-24; // a link of zero length has no direction and gets no force
constexpr double kTouchMargin_m = 1e-3;
constexpr double kMaxHandlePosition_m = 10;
constexpr double kMaxForce_n = 1e3;
} // namespace

static_assert(kMaxStepsPerTick <= 1024, "NetworkModel::samples_ must hold one tick");

Vec3 NetworkModel::force(const Tick& tick, const State& state) noexcept {
  take_network();
  sample_count_ = 0;
  const Vec3 goal = limited(state.position, kMaxHandlePosition_m);
  if (!started_) {
    handle_ = goal;
    handle_velocity_ = {};
    started_ = true;
  }
  if (!network_ || !(tick.period_s > 0))
    return {};
  const auto [steps, stride] = steps_per_tick(*network_, published_->max_step_s, tick.period_s);
  if (steps == 0)
    return {};
  step_s_ = tick.period_s / steps;
  const Vec3 start = handle_, velocity = (goal - start) * (1.0 / tick.period_s);
  find_candidates(start, goal, tick.period_s);
  take_actions(start);
  const double before_j = handle_energy_j();
  raise_gains(tick.period_s);
  budget_j_ += handle_energy_j() - before_j; // a growing gain adds energy
  if (!has_budget_)
    budget_j_ = energy_j();
  has_budget_ = true;

  Vec3 force_sum{};
  double work_j = 0;
  for (int step = 0; step < steps; ++step) {
    apply_links();
    const NetworkSample pickups = read_pickups();
    NetworkSample& mean = samples_[static_cast<std::size_t>(step / stride)];
    for (std::size_t p = 0; p < pickups.size(); ++p)
      mean[p] = (step % stride == 0 ? 0.0f : mean[p]) + pickups[p] / static_cast<float>(stride);
    const Vec3 handle = start + (goal - start) * (static_cast<double>(step) / steps);
    const Vec3 force = apply_handle(handle, velocity);
    force_sum += force;
    // The energy with the handle's springs changes by F . (x_h+ - x_h-)/2.
    work_j += dot(force, step == 0 ? (velocity + handle_velocity_) * 0.5 : velocity) * step_s_;
    apply_plucks();
    integrate();
    work_j += work_of_plucks();
    end_plucks();
  }
  sample_count_ = static_cast<std::size_t>(steps / stride);
  handle_ = goal;
  handle_velocity_ = velocity;
  clamp_state();
  limit_energy(work_j, tick.period_s);
  return limited(force_sum * (-1.0 / steps), kMaxForce_n);
}

/// Collects the masses that the sphere around the handle can reach in this tick.
void NetworkModel::find_candidates(const Vec3& from, const Vec3& to, double period_s) noexcept {
  candidate_count_ = 0;
  const NetworkTouch& touch = network_->touch;
  if (!(touch.stiffness_n_per_m > 0) || !(touch.radius_m > 0))
    return;
  const Vec3 middle = (from + to) * 0.5;
  const double reach = touch.radius_m + 0.5 * norm(to - from) + kTouchMargin_m;
  for (std::size_t i = 0; i < count_; ++i) {
    const Vec3 offset = position(i) - middle, v = this->velocity(i);
    const double travel = 2 * period_s * (std::abs(v.x) + std::abs(v.y) + std::abs(v.z));
    if (inverse_mass_[i] > 0 && dot(offset, offset) < (reach + travel) * (reach + travel))
      candidates_[candidate_count_++] = static_cast<std::uint16_t>(i);
  }
}

/// Ramps the gains of the handle's springs. A mass that enters the sphere by its own motion has the
/// full gain.
void NetworkModel::raise_gains(double period_s) noexcept {
  const double rise = period_s / kContactRamp_s;
  if (network_->touch.stiffness_n_per_m > 0 && network_->touch.radius_m > 0)
    for (std::size_t i = 0; i < count_; ++i) {
      double& gain = touch_gain_[i];
      if (gain < 0)
        gain = norm(position(i) - handle_) < network_->touch.radius_m ? 0 : 1;
      else
        gain = std::min(1.0, gain + rise);
    }
  if (grabbed_ != kNoKey)
    grab_gain_ = std::min(1.0, grab_gain_ + rise);
}

void NetworkModel::apply_links() noexcept {
  std::fill_n(fx_.begin(), count_, 0.0);
  std::fill_n(fy_.begin(), count_, 0.0);
  std::fill_n(fz_.begin(), count_, 0.0);
  for (const NetworkLink& link : network_->links) {
    const std::size_t a = link.a, b = link.b;
    const double dx = x_[b] - x_[a], dy = y_[b] - y_[a], dz = z_[b] - z_[a];
    const double wx = vx_[b] - vx_[a], wy = vy_[b] - vy_[a], wz = vz_[b] - vz_[a];
    // The force of network.hpp, written as along d + b_t w.
    const double bt = link.transverse_damping_n_s_per_m;
    double along = link.stiffness_n_per_m;
    const double bn = link.damping_n_s_per_m - bt; // b_n - b_t
    // Without a rest length and with equal dampings the link is linear and needs no direction.
    if (link.rest_length_m > 0 || bn != 0 || link.kind != NetworkLink::Kind::kSpring) {
      const double length2 = std::max(dx * dx + dy * dy + dz * dz, kMinLength2_m2);
      const double inverse = 1.0 / std::sqrt(length2);
      const double stretch = 1.0 - link.rest_length_m * inverse; // stretch relative to the length
      if ((link.kind == NetworkLink::Kind::kPull && stretch < 0) ||
          (link.kind == NetworkLink::Kind::kPush && stretch > 0))
        continue;
      along = along * stretch + bn * (wx * dx + wy * dy + wz * dz) * inverse * inverse;
    }
    const double gx = along * dx + bt * wx, gy = along * dy + bt * wy, gz = along * dz + bt * wz;
    fx_[a] += gx, fy_[a] += gy, fz_[a] += gz;
    fx_[b] -= gx, fy_[b] -= gy, fz_[b] -= gz;
  }
}

void NetworkModel::add_force(std::size_t mass, const Vec3& force) noexcept {
  fx_[mass] += force.x, fy_[mass] += force.y, fz_[mass] += force.z;
}

/// Adds the forces of the sphere and of the grabbing spring; returns their sum.
Vec3 NetworkModel::apply_handle(const Vec3& handle, const Vec3& handle_velocity) noexcept {
  Vec3 sum{};
  const NetworkTouch& touch = network_->touch;
  for (std::size_t c = 0; c < candidate_count_; ++c) {
    const std::size_t i = candidates_[c];
    const Vec3 offset = position(i) - handle;
    const double length2 = dot(offset, offset);
    if (length2 >= touch.radius_m * touch.radius_m || length2 < kMinLength2_m2)
      continue;
    const double length = std::sqrt(length2);
    const Vec3 normal = offset * (1.0 / length);
    const double separation_speed = dot(velocity(i) - handle_velocity, normal);
    const double contact_force =
        std::min(touch_gain_[i] * (touch.stiffness_n_per_m * (touch.radius_m - length) -
                                   touch.damping_n_s_per_m * separation_speed),
                 kMaxHandle_n);
    if (contact_force <= 0)
      continue;
    const Vec3 force = normal * contact_force;
    add_force(i, force);
    sum += force;
  }
  if (grabbed_ != kNoKey) {
    const NetworkGrab& grab = network_->grab;
    const std::size_t i = grabbed_mass_;
    const Vec3 force = limited(((handle - position(i)) * grab.stiffness_n_per_m +
                                (handle_velocity - velocity(i)) * grab.damping_n_s_per_m) *
                                   grab_gain_,
                               kMaxHandle_n);
    add_force(i, force);
    sum += force;
  }
  return sum;
}

void NetworkModel::apply_plucks() noexcept {
  for (RunningPluck& pluck : plucks_)
    if (pluck.key != kNoKey) {
      add_force(pluck.mass, pluck.force_n);
      pluck.velocity_before = velocity(pluck.mass);
    }
}

void NetworkModel::end_plucks() noexcept {
  for (RunningPluck& pluck : plucks_) {
    pluck.remaining_s -= step_s_;
    if (pluck.remaining_s < 0.5 * step_s_)
      pluck.key = kNoKey;
  }
}

void NetworkModel::integrate() noexcept {
  const double h = step_s_, velocity_decay = 1.0 - h * network_->drag_per_s;
  const Vec3 gravity_step = network_->gravity * h;
  for (std::size_t i = 0; i < count_; ++i) {
    const double movable = inverse_mass_[i] > 0 ? 1.0 : 0.0;
    vx_[i] = vx_[i] * velocity_decay + h * fx_[i] * inverse_mass_[i] + gravity_step.x * movable;
    vy_[i] = vy_[i] * velocity_decay + h * fy_[i] * inverse_mass_[i] + gravity_step.y * movable;
    vz_[i] = vz_[i] * velocity_decay + h * fz_[i] * inverse_mass_[i] + gravity_step.z * movable;
    x_[i] += h * vx_[i];
    y_[i] += h * vy_[i];
    z_[i] += h * vz_[i];
  }
}

/// Reads the pickups at the start of a step: the forces of the links at that time, and the
/// velocities half a step earlier.
NetworkSample NetworkModel::read_pickups() const noexcept {
  NetworkSample sample{};
  for (std::size_t p = 0; p < sample.size(); ++p) {
    const NetworkPickup& pickup = network_->pickups[p];
    const std::size_t i = pickup.mass;
    if (i >= count_)
      continue;
    using Quantity = NetworkPickup::Quantity;
    double value = 0;
    switch (pickup.quantity) {
    case Quantity::kVelocity:
      value = velocity(i)[pickup.axis];
      break;
    case Quantity::kDisplacement:
      value = (position(i) - network_->masses[i].position)[pickup.axis];
      break;
    case Quantity::kForce:
      value = force_on(i)[pickup.axis];
      break;
    }
    sample[p] = static_cast<float>(value);
  }
  return sample;
}

} // namespace tactus::haptic

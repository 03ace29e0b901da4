#include "core/haptic/network/network_model.hpp"

#include "core/haptic/network/stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

/// NetworkModel's networks and actions from the host; network_step.cpp has the steps.
namespace tactus::haptic {
namespace {
constexpr int kMaxActions = 16; // actions per tick; the rest stay in the queue
}

NetworkModel::~NetworkModel() {
  collect();
  delete pending_.load();
  delete published_;
}

void NetworkModel::publish(std::unique_ptr<const Network> network) {
  const double max_step_s = max_stable_step(*network).step_s;
  auto published = std::make_unique<const Published>(Published{std::move(network), max_step_s});
  delete pending_.exchange(published.release(), std::memory_order_acq_rel);
  collect();
}

void NetworkModel::collect() noexcept {
  const Published* done = nullptr;
  while (retired_.pop(done))
    delete done;
}

void NetworkModel::begin() noexcept {
  started_ = has_budget_ = false;
  grabbed_ = kNoKey;
  sample_count_ = 0;
  touch_gain_.fill(-1);
}

/// The gain for which a sphere that has grown pushes a mass with the same force as before; -1 for a
/// mass that the sphere did not touch.
double NetworkModel::gain_after_growth(double before_m, std::size_t mass) const noexcept {
  const double distance = norm(position(mass) - handle_);
  return touch_gain_[mass] >= 0 && distance < before_m
             ? touch_gain_[mass] * (before_m - distance) / (network_->touch.radius_m - distance)
             : -1;
}

/// Keys ascend along both lists, so that one pass finds the masses that stay.
void NetworkModel::take_network() noexcept {
  // Read before the old network is returned, since the host may free it at once.
  const double radius_m = network_ ? network_->touch.radius_m : 0.0;
  if (!pending_.load(std::memory_order_relaxed) || (published_ && !retired_.push(published_)))
    return;
  published_ = pending_.exchange(nullptr, std::memory_order_acq_rel);
  network_ = published_->network.get();
  const bool grows = network_->touch.radius_m > radius_m;

  const std::size_t count = std::min(network_->masses.size(), kPoints);
  Row x{}, y{}, z{}, vx{}, vy{}, vz{}, gain{};
  for (std::size_t i = 0, old = 0; i < count; ++i) {
    const NetworkMass& mass = network_->masses[i];
    while (old < count_ && keys_[old] < mass.key)
      ++old;
    const bool kept = old < count_ && keys_[old] == mass.key;
    x[i] = kept ? x_[old] : mass.position.x;
    y[i] = kept ? y_[old] : mass.position.y;
    z[i] = kept ? z_[old] : mass.position.z;
    gain[i] = !kept ? -1 : grows ? gain_after_growth(radius_m, old) : touch_gain_[old];
    if (kept && !mass.fixed) {
      vx[i] = vx_[old];
      vy[i] = vy_[old];
      vz[i] = vz_[old];
    }
  }
  x_ = x, y_ = y, z_ = z;
  vx_ = vx, vy_ = vy, vz_ = vz;
  touch_gain_ = gain;
  count_ = count;
  has_budget_ = false;
  for (std::size_t i = 0; i < count; ++i) {
    const NetworkMass& mass = network_->masses[i];
    keys_[i] = mass.key;
    mass_[i] = mass.mass_kg;
    inverse_mass_[i] = mass.fixed ? 0.0 : 1.0 / mass.mass_kg;
    fx_[i] = fy_[i] = fz_[i] = 0;
  }
  grabbed_mass_ = find(grabbed_);
  if (grabbed_mass_ == NetworkPickup::kNone)
    grabbed_ = kNoKey;
  for (RunningPluck& pluck : plucks_) {
    pluck.mass = find(pluck.key);
    if (pluck.mass == NetworkPickup::kNone)
      pluck.key = kNoKey;
  }
}

std::size_t NetworkModel::find(std::uint64_t key) const noexcept {
  const auto end = keys_.begin() + static_cast<std::ptrdiff_t>(count_);
  const auto found = std::lower_bound(keys_.begin(), end, key);
  return found != end && *found == key ? static_cast<std::size_t>(found - keys_.begin())
                                       : NetworkPickup::kNone;
}

void NetworkModel::take_actions(const Vec3& handle) noexcept {
  Action action;
  for (int taken = 0; taken < kMaxActions && actions_.pop(action); ++taken) {
    if (const auto* const pluck = std::get_if<Pluck>(&action))
      begin(*pluck);
    else if (const auto* const wanted = std::get_if<Grab>(&action))
      grab(find(wanted->key));
    else if (std::holds_alternative<GrabNearest>(action))
      grab(nearest_movable(handle));
    else if (std::holds_alternative<Release>(action))
      grabbed_ = kNoKey;
    else
      reset();
  }
}

void NetworkModel::begin(const Pluck& pluck) noexcept {
  const std::size_t mass = find(pluck.key);
  if (!movable(mass))
    return;
  // The duration is rounded to whole steps; the force is scaled to keep the impulse.
  const double duration_s = pluck.duration_s > 0 ? std::min(pluck.duration_s, 100.0) : 0.0;
  const double steps = std::max(1.0, std::floor(duration_s / step_s_ + 0.5));
  RunningPluck* free = std::find_if(plucks_.begin(), plucks_.end(),
                                    [](const RunningPluck& one) { return one.key == kNoKey; });
  if (free == plucks_.end())
    free = plucks_.begin();
  *free = {pluck.key, mass, limited(pluck.force_n, kMaxPluck_n) * (duration_s / (steps * step_s_)),
           steps * step_s_};
}

std::size_t NetworkModel::nearest_movable(const Vec3& position_m) const noexcept {
  std::size_t nearest = NetworkPickup::kNone;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count_; ++i) {
    const double distance = norm(position(i) - position_m);
    if (movable(i) && distance < best) {
      best = distance;
      nearest = i;
    }
  }
  return nearest;
}

void NetworkModel::grab(std::size_t mass) noexcept {
  if (!movable(mass))
    return;
  grabbed_mass_ = mass;
  if (grabbed_ != keys_[mass])
    grab_gain_ = 0;
  grabbed_ = keys_[mass];
}

void NetworkModel::reset() noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    const Vec3& rest = network_->masses[i].position;
    x_[i] = rest.x, y_[i] = rest.y, z_[i] = rest.z;
    vx_[i] = vy_[i] = vz_[i] = 0;
    fx_[i] = fy_[i] = fz_[i] = 0;
  }
  grabbed_ = kNoKey;
  plucks_ = {};
  has_budget_ = false;
}

/// Bounds the state and removes denormal numbers, which would slow down later ticks.
void NetworkModel::clamp_state() noexcept {
  constexpr double kTiny = 1e-30;
  const auto bound = [](double& value, double largest) {
    value = std::abs(value) < kTiny ? 0.0 : std::clamp(value, -largest, largest);
  };
  for (std::size_t i = 0; i < count_; ++i) {
    for (Row* row : {&x_, &y_, &z_})
      bound((*row)[i], kMaxPosition_m);
    for (Row* row : {&vx_, &vy_, &vz_})
      bound((*row)[i], kMaxSpeed_m_per_s);
  }
}

Vec3 NetworkModel::position(std::size_t mass) const noexcept {
  return {x_[mass], y_[mass], z_[mass]};
}

Vec3 NetworkModel::velocity(std::size_t mass) const noexcept {
  return {vx_[mass], vy_[mass], vz_[mass]};
}

Vec3 NetworkModel::force_on(std::size_t mass) const noexcept {
  return {fx_[mass], fy_[mass], fz_[mass]};
}

} // namespace tactus::haptic

#include "core/haptic/scene/scene_model.hpp"

/// SceneModel's force.
namespace tactus::haptic {

/// The equation of scene_model.hpp: the normal part of the spring between handle and proxy with
/// each body's stiffness, the tangential part with their mean, and the damping of the approach.
Vec3 SceneModel::render(const Tick& tick, const Vec3& goal, const Vec3& velocity) noexcept {
  std::fill_n(body_force_.begin(), count_, Vec3{});
  double total_penetration = 0, total_spring_force = 0;
  for (const Touch& touch : touches_.all()) {
    total_penetration += touch.penetration_m;
    total_spring_force += slots_[touch.slot].body->material.stiffness_n_per_m * touch.penetration_m;
  }
  if (!(total_penetration > 0.0))
    return {};
  Vec3 friction_force =
      (proxy_ - goal - touches_.normal_part()) * (total_spring_force / total_penetration);
  // The distance to a proxy that has not arrived yet is not entirely due to friction.
  if (!complete_)
    friction_force =
        limited(friction_force, friction_of(touches_.all(), near_bodies()) * total_spring_force);
  Vec3 sum;
  bool overlapping = false;
  for (const Touch& touch : touches_.all()) {
    const Slot& slot = slots_[touch.slot];
    const Material& material = slot.body->material;
    const double depth = std::max(touch.penetration_m - Proxy::kSkin_m, 0.0);
    const double separation_speed =
        dot(velocity - velocity_of(slot, proxy_, tick.period_s), touch.normal);
    const double spring = material.stiffness_n_per_m * depth;
    const double normal = spring + material.damping_n_s_per_m * std::max(-separation_speed, 0.0);
    const double part = total_spring_force > 0.0
                            ? material.stiffness_n_per_m * touch.penetration_m / total_spring_force
                            : 0.0;
    const Vec3 force = touch.normal * normal + friction_force * part;
    body_force_[touch.slot] += force;
    if (slot.overlap_start_s >= 0)
      overlapping = true;
    else
      sum += force;
  }
  return overlapping ? sum + limit_overlap_force(tick) : sum;
}

/// The limited force of the bodies that appeared around the handle. A body leaves this state once
/// its force is below the limit.
Vec3 SceneModel::limit_overlap_force(const Tick& tick) noexcept {
  const double continuous = continuous_force_n_.load(std::memory_order_relaxed);
  const double limit =
      continuous > 0.0 ? std::min(continuous, kMaxOverlapForce_n) : kMaxOverlapForce_n;
  std::array<std::size_t, 3> slot_of{};
  std::array<bool, 3> limited_by_ramp{};
  std::size_t count = 0;
  double before = 0;
  Vec3 sum;
  for (const Touch& touch : touches_.all()) {
    const Slot& slot = slots_[touch.slot];
    const auto end = slot_of.begin() + static_cast<std::ptrdiff_t>(count);
    if (slot.overlap_start_s < 0 || std::find(slot_of.begin(), end, touch.slot) != end)
      continue;
    const double ramped =
        slot.overlap_start_force_n +
        kOverlapForceRise_n_per_s * std::max(tick.time_s - slot.overlap_start_s, 0.0);
    const double allowed = std::min(ramped, std::max(limit, slot.overlap_start_force_n));
    Vec3& force = body_force_[touch.slot];
    limited_by_ramp[count] = norm(force) > allowed;
    force = limited(force, allowed);
    before += slot.overlap_start_force_n;
    slot_of[count++] = touch.slot;
    sum += force;
  }
  const double total = norm(sum), total_limit = std::max(limit, before);
  for (std::size_t i = 0; i < count; ++i)
    if (total > total_limit)
      body_force_[slot_of[i]] = body_force_[slot_of[i]] * (total_limit / total);
    else if (!limited_by_ramp[i])
      slots_[slot_of[i]].overlap_start_s = -1;
  return limited(sum, total_limit);
}

Vec3 SceneModel::velocity_of(const Slot& slot, const Vec3& point, double period_s) const noexcept {
  if (!slot.moved())
    return {};
  return (point - slot.before.to_world(slot.pose.to_local(point))) * (1.0 / period_s);
}

} // namespace tactus::haptic

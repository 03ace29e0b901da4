#include "core/haptic/scene/scene_model.hpp"

/// The force of the contact.
namespace tactus::haptic {

/// The spring between handle and proxy, split into the faces' normal parts, each with its body's
/// stiffness, and what friction holds, with their mean; and the dampers of the approach.
Vec3 SceneModel::render(const Tick& tick, const Vec3& goal, const Vec3& velocity) noexcept {
  std::fill_n(body_force_.begin(), count_, Vec3{});
  double pushes = 0, springs = 0;
  for (const Touch& touch : touches_.all()) {
    pushes += touch.push_m;
    springs += slots_[touch.slot].body->material.stiffness_n_per_m * touch.push_m;
  }
  if (!(pushes > 0.0))
    return {};
  Vec3 dragged = (proxy_ - goal - touches_.normal_part()) * (springs / pushes);
  // A proxy that is still on its way is not held back by friction alone.
  if (!complete_)
    dragged = limited(dragged, friction_of(touches_) * springs);
  Vec3 sum;
  bool emerging = false;
  for (const Touch& touch : touches_.all()) {
    const Slot& slot = slots_[touch.slot];
    const Material& material = slot.body->material;
    const double depth = std::max(touch.push_m - Proxy::kSkin_m, 0.0);
    const double receding = dot(velocity - velocity_of(slot, proxy_, tick.period_s), touch.normal);
    const double spring = material.stiffness_n_per_m * depth;
    const double normal = spring + material.damping_n_s_per_m * std::max(-receding, 0.0);
    const double part = springs > 0.0 ? material.stiffness_n_per_m * touch.push_m / springs : 0.0;
    const Vec3 force = touch.normal * normal + dragged * part;
    body_force_[touch.slot] += force;
    if (slot.emerged_s >= 0)
      emerging = true;
    else
      sum += force;
  }
  return emerging ? sum + limit_emerging(tick) : sum;
}

/// What the bodies that appeared around the handle give together. Each counts as such until its
/// force needs no limit.
Vec3 SceneModel::limit_emerging(const Tick& tick) noexcept {
  const double continuous = continuous_force_n_.load(std::memory_order_relaxed);
  const double limit = continuous > 0.0 ? std::min(continuous, kMaxEmerging_n) : kMaxEmerging_n;
  std::array<std::size_t, 3> slot_of{};
  std::array<bool, 3> cut{};
  std::size_t count = 0;
  double before = 0;
  Vec3 sum;
  for (const Touch& touch : touches_.all()) {
    const Slot& slot = slots_[touch.slot];
    const auto end = slot_of.begin() + static_cast<std::ptrdiff_t>(count);
    if (slot.emerged_s < 0 || std::find(slot_of.begin(), end, touch.slot) != end)
      continue;
    const double risen =
        slot.emerged_n + kEmerging_n_per_s * std::max(tick.time_s - slot.emerged_s, 0.0);
    const double allowed = std::min(risen, std::max(limit, slot.emerged_n));
    Vec3& force = body_force_[touch.slot];
    cut[count] = norm(force) > allowed;
    force = limited(force, allowed);
    before += slot.emerged_n;
    slot_of[count++] = touch.slot;
    sum += force;
  }
  const double total = norm(sum), total_limit = std::max(limit, before);
  for (std::size_t i = 0; i < count; ++i)
    if (total > total_limit)
      body_force_[slot_of[i]] = body_force_[slot_of[i]] * (total_limit / total);
    else if (!cut[i])
      slots_[slot_of[i]].emerged_s = -1;
  return limited(sum, total_limit);
}

Vec3 SceneModel::velocity_of(const Slot& slot, const Vec3& point, double period_s) const noexcept {
  if (!slot.moved())
    return {};
  return (point - slot.before.to_world(slot.pose.to_local(point))) * (1.0 / period_s);
}

} // namespace tactus::haptic

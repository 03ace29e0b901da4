#include "core/dsp/elementary.hpp"
#include "core/haptic/scene/scene_model.hpp"

/// SceneModel's events: hits, contacts and releases.
namespace tactus::haptic {

void SceneModel::push_events(const Tick& tick) noexcept {
  std::array<const Touch*, Scene::kMaxBodies> now{};
  std::array<double, Scene::kMaxBodies> depth{};
  for (const Touch& touch : touches_.all()) {
    depth[touch.slot] = math::hypot(depth[touch.slot], touch.penetration_m);
    if (!now[touch.slot] || touch.penetration_m > now[touch.slot]->penetration_m)
      now[touch.slot] = &touch;
  }
  WorkLimit work(work_per_tick_ / 8);
  for (std::size_t i = 0; i < count_; ++i) {
    Slot& slot = slots_[i];
    if (now[i] && !slot.touching) {
      const Vec3& normal = now[i]->normal;
      const Vec3 point = proxy_ - normal * (Proxy::kSkin_m + tool_radius_m_);
      const Vec3 v = previous_velocity_ - velocity_of(slot, point, tick.period_s);
      const HitEvent hit{slot.key, tick.time_s,     point,
                         normal,   -dot(v, normal), norm(without_component(v, normal))};
      if (slot.armed && slot.overlap_start_s < 0 && hit.approach_m_per_s >= kMinHit_m_per_s)
        events_.push(hit);
      slot.armed = slot.separated = false;
      slot.reported_s = -1e9;
    }
    if (now[i] && tick.time_s - slot.reported_s >= kContactEvery_s - 1e-9) {
      events_.push(ContactEvent{slot.key, tick.time_s, depth[i], body_force_[i]});
      slot.reported_s = tick.time_s;
    }
    // Only a complete search shows that the proxy is free of a body.
    const bool touching = now[i] != nullptr || (slot.touching && !complete_);
    if (!touching && slot.touching) {
      events_.push(ReleaseEvent{slot.key, tick.time_s});
      slot.released_s = tick.time_s;
      slot.overlap_start_s = -1;
    }
    slot.touching = touching;
    slot.force_n = norm(body_force_[i]);
    rearm(slot, tick, work);
  }
}

/// Arms the next hit once the tool has been kRearm_m away from the body since the last release, and
/// kRearm_s has passed since that release. With only one of the conditions, the chatter of a handle
/// that trembles at the surface would count as hits.
void SceneModel::rearm(Slot& slot, const Tick& tick, WorkLimit& work) noexcept {
  if (slot.touching || slot.armed)
    return;
  if (!slot.separated)
    slot.separated =
        is_farther(slot.body->shape, slot.pose.to_local(proxy_), tool_radius_m_ + kRearm_m, work);
  slot.armed = slot.separated && tick.time_s - slot.released_s >= kRearm_s - 1e-9;
}

} // namespace tactus::haptic

#include "core/haptic/scene/scene_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

/// The scene and its bodies' motion; scene_contact.cpp has the contact.
namespace tactus::haptic {

SceneModel::~SceneModel() {
  collect();
  delete pending_.load();
  delete scene_;
}

void SceneModel::publish(std::unique_ptr<const Scene> scene) {
  delete pending_.exchange(scene.release(), std::memory_order_acq_rel);
  collect();
}

void SceneModel::collect() noexcept {
  const Scene* done = nullptr;
  while (retired_.pop(done))
    delete done;
}

void SceneModel::begin() noexcept {
  started_ = false;
  touches_.count = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    Slot& slot = slots_[i];
    slot.touching = false;
    slot.armed = slot.fresh = true;
    slot.emerged_s = -1;
  }
}

void SceneModel::take_scene(const Tick& tick) noexcept {
  // Only this side takes away, so what is there now is still there for the exchange. While the
  // host leaves the shelf full, the new scene waits.
  if (!pending_.load(std::memory_order_relaxed) || (scene_ && !retired_.push(scene_)))
    return;
  scene_ = pending_.exchange(nullptr, std::memory_order_acq_rel);

  std::array<Slot, Scene::kMostBodies> next{};
  std::array<bool, Scene::kMostBodies> kept{};
  std::array<std::size_t, Scene::kMostBodies> place{};
  const std::size_t count = std::min(scene_->bodies.size(), Scene::kMostBodies);
  for (std::size_t i = 0; i < count; ++i) {
    const Body& body = scene_->bodies[i];
    Slot& slot = next[i];
    for (std::size_t j = 0; j < count_; ++j)
      if (slots_[j].key == body.key) {
        slot = slots_[j];
        kept[j] = true;
        place[j] = i;
        break;
      }
    if (slot.fresh && !slot.body)
      slot.pose = slot.before = slot.start = slot.goal = body.pose;
    slot.body = &body;
    slot.key = body.key;
    if (!(slot.goal == body.pose)) {
      slot.start = slot.pose;
      slot.goal = body.pose;
      slot.glided = 0;
      slot.glide_ticks = std::clamp(std::floor(body.glide_s / tick.period_s + 0.5), 1.0, 1e9);
    }
  }
  for (std::size_t j = 0; j < count_; ++j)
    if (!kept[j] && slots_[j].touching) {
      ContactEvent event;
      event.kind = ContactEvent::Kind::kRelease;
      event.key = slots_[j].key;
      event.time_s = tick.time_s;
      events_.push(event);
    }
  std::size_t held = 0;
  for (const Touch& touch : touches_.all())
    if (kept[touch.slot]) {
      touches_.touch[held] = touch;
      touches_.touch[held++].slot = place[touch.slot];
    }
  touches_.count = held;
  slots_ = next;
  count_ = count;
}

void SceneModel::glide(Slot& slot) noexcept {
  slot.before = slot.pose;
  if (slot.glided >= slot.glide_ticks)
    return;
  slot.glided += 1;
  if (slot.glided >= slot.glide_ticks) {
    slot.pose = slot.goal;
    return;
  }
  const double share = slot.glided / slot.glide_ticks;
  const Rotation &a = slot.start.rotation, &b = slot.goal.rotation;
  const double near = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z < 0 ? -share : share;
  slot.pose.position = slot.start.position + (slot.goal.position - slot.start.position) * share;
  slot.pose.rotation = Rotation::of(a.w + near * b.w - share * a.w, a.x + near * b.x - share * a.x,
                                    a.y + near * b.y - share * a.y, a.z + near * b.z - share * a.z);
}

/// Bodies that have appeared around the proxy let it out by their nearest face.
void SceneModel::emerge(const Tick& tick) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    Slot& slot = slots_[i];
    if (!std::exchange(slot.fresh, false))
      continue;
    const auto out = nearest_way_out(slot.body->shape, slot.pose.to_local(proxy_));
    if (!out)
      continue;
    proxy_ = slot.pose.to_world(out->point + out->normal * Proxy::kSkin_m);
    slot.emerged_s = tick.time_s;
  }
}

/// A moving body takes the proxy that it holds with it, and pushes one that stands in its way.
void SceneModel::carry() noexcept {
  const std::size_t holder = touches_.count > 0 ? touches_.touch[0].slot : Proxy::kNobody;
  for (std::size_t i = 0; i < count_; ++i) {
    const Slot& slot = slots_[i];
    if (!slot.moved())
      continue;
    const Vec3 was = slot.before.to_local(proxy_);
    Vec3 wanted;
    if (i == holder) {
      wanted = slot.pose.to_world(was);
    } else {
      const Vec3 is = slot.pose.to_local(proxy_);
      const auto met = crossing(slot.body->shape, was, is);
      if (!met)
        continue;
      const Vec3 point = was + (is - was) * met->share;
      wanted = slot.pose.to_world(point + met->normal * Proxy::kSkin_m);
    }
    // Another body may stand behind: the proxy stays before it, and the moving one passes over it.
    const Proxy::Stop stop = Proxy::sweep(proxy_, wanted, {near_.data(), near_count_}, i);
    proxy_ = stop.met ? proxy_ + (wanted - proxy_) * (stop.share * (1 - 1e-9)) : wanted;
  }
}

Vec3 SceneModel::velocity_of(const Slot& slot, const Vec3& point, double period_s) const noexcept {
  if (!slot.moved())
    return {};
  return (point - slot.before.to_world(slot.pose.to_local(point))) * (1.0 / period_s);
}

} // namespace tactus::haptic

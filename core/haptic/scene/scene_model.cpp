#include "core/haptic/scene/scene_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

/// SceneModel's exchange of scenes and motion of bodies; scene_contact.cpp has the proxy.
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
  complete_ = true;
  max_motion_m_ = kUnlimitedMotion;
  touches_.count = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    Slot& slot = slots_[i];
    slot.touching = false;
    slot.armed = slot.is_new = true;
    slot.overlap_start_s = -1;
  }
}

void SceneModel::take_scene(const Tick& tick) noexcept {
  // Only the servo takes a pending scene, so the scene is still there at the exchange. While the
  // ring of returned scenes is full, the new scene has to wait.
  if (!pending_.load(std::memory_order_relaxed) || (scene_ && !retired_.push(scene_)))
    return;
  scene_ = pending_.exchange(nullptr, std::memory_order_acq_rel);

  // A larger tool may overlap bodies that the smaller one did not reach.
  const bool grows = scene_->tool_radius_m > tool_radius_m_;
  // A smaller tool no longer touches the faces that held the proxy.
  const bool shrinks = scene_->tool_radius_m < tool_radius_m_;
  tool_radius_m_ = scene_->tool_radius_m;
  std::array<Slot, Scene::kMaxBodies> next{};
  std::array<bool, Scene::kMaxBodies> kept{};
  std::array<std::size_t, Scene::kMaxBodies> new_index{};
  const std::size_t count = std::min(scene_->bodies.size(), Scene::kMaxBodies);
  for (std::size_t i = 0; i < count; ++i) {
    const Body& body = scene_->bodies[i];
    Slot& slot = next[i];
    for (std::size_t j = 0; j < count_; ++j)
      if (slots_[j].key == body.key) {
        slot = slots_[j];
        kept[j] = true;
        new_index[j] = i;
        break;
      }
    if (slot.is_new && !slot.body)
      slot.pose = slot.before = slot.start = slot.goal = body.pose;
    slot.is_new = slot.is_new || grows;
    slot.body = &body;
    slot.key = body.key;
    if (!(slot.goal == body.pose)) {
      slot.start = slot.pose;
      slot.goal = body.pose;
      slot.glide_elapsed_ticks = 0;
      slot.glide_ticks = std::clamp(std::floor(body.glide_s / tick.period_s + 0.5), 1.0, 1e9);
    }
  }
  for (std::size_t j = 0; j < count_; ++j)
    if (!kept[j] && slots_[j].touching)
      events_.push(ReleaseEvent{slots_[j].key, tick.time_s});
  std::size_t held = 0;
  for (const Touch& touch : touches_.all())
    if (kept[touch.slot] && !shrinks) {
      touches_.touch[held] = touch;
      touches_.touch[held++].slot = new_index[touch.slot];
    }
  touches_.count = held;
  slots_ = next;
  count_ = count;
}

void SceneModel::glide(Slot& slot) noexcept {
  slot.before = slot.pose;
  if (slot.glide_elapsed_ticks >= slot.glide_ticks)
    return;
  slot.glide_elapsed_ticks += 1;
  if (slot.glide_elapsed_ticks >= slot.glide_ticks) {
    slot.pose = slot.goal;
    return;
  }
  const double share = slot.glide_elapsed_ticks / slot.glide_ticks;
  const Rotation &a = slot.start.rotation, &b = slot.goal.rotation;
  const double signed_share = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z < 0 ? -share : share;
  slot.pose.position = slot.start.position + (slot.goal.position - slot.start.position) * share;
  slot.pose.rotation =
      Rotation::of(a.w + signed_share * b.w - share * a.w, a.x + signed_share * b.x - share * a.x,
                   a.y + signed_share * b.y - share * a.y, a.z + signed_share * b.z - share * a.z);
}

/// Moves the proxy out of bodies that have appeared around it, through their nearest faces; if an
/// exit lies in another body, out of that body in turn. If the bodies leave no room for the tool,
/// the proxy stays and does not touch the bodies that it overlaps.
void SceneModel::resolve_overlaps(const Tick& tick, WorkLimit& work) noexcept {
  constexpr int kRounds = 8, kExitWork = 10;
  const std::size_t first = std::exchange(first_overlapping_, 0);
  bool moved = false, tested = false;
  for (int round = 0; round < kRounds && (round == 0 || moved); ++round) {
    moved = false;
    for (std::size_t n = 0; n < count_; ++n) {
      const std::size_t i = (first + n) % count_;
      Slot& slot = slots_[i];
      if (round == 0 && !slot.is_new)
        continue;
      work.spend(kExitWork);
      const auto exit_point =
          nearest_exit(slot.body->shape, tool_radius_m_, slot.pose.to_local(proxy_), work);
      if (work.exhausted()) { // a body that exceeds the work alone must not block the others
        first_overlapping_ = tested ? i : i + 1;
        return;
      }
      tested = true;
      slot.is_new = false;
      if (!exit_point)
        continue;
      proxy_ = slot.pose.to_world(exit_point->point + exit_point->normal * Proxy::kSkin_m);
      slot.overlap_start_s = tick.time_s;
      slot.overlap_start_force_n = slot.touching ? slot.force_n : 0.0;
      moved = true;
    }
  }
}

/// The body that holds the proxy with the largest friction. When several bodies rub on the proxy in
/// different directions, the proxy follows this body, since the proxy has no mass.
std::size_t SceneModel::holding_body() const noexcept {
  std::size_t holder = Proxy::kNoSlot;
  double largest = -1;
  for (const Touch& touch : touches_.all()) {
    double friction_n = 0;
    for (const Touch& other : touches_.all())
      if (other.slot == touch.slot) {
        const Material& material = slots_[other.slot].body->material;
        friction_n += material.friction * material.stiffness_n_per_m * other.penetration_m;
      }
    if (friction_n > largest) {
      largest = friction_n;
      holder = touch.slot;
    }
  }
  return holder;
}

/// Moves the bodies by one tick. The body that holds the proxy takes it along; another body pushes
/// a proxy that is in its path. Bodies move one after another, so that the proxy is outside of all
/// of them after each motion. A body for which the work does not suffice keeps its pose until the
/// next tick.
void SceneModel::move_bodies(WorkLimit& work) noexcept {
  for (Obstacle& obstacle : std::span(near_bodies_.data(), near_body_count_)) {
    const Slot& slot = slots_[obstacle.slot];
    if (slot.moved()) {
      obstacle.pose = slot.before;
      obstacle.bounds = bounds_of(slot.body->shape, slot.before);
    }
  }
  const std::size_t holder = holding_body();
  const std::size_t first = std::exchange(first_moving_, 0);
  bool postponed = false, any_moved = false;
  for (std::size_t n = 0; n < count_; ++n) {
    const std::size_t i = (first + n) % count_;
    Slot& slot = slots_[i];
    if (!slot.moved())
      continue;
    if (!postponed && move_body(i, i == holder, work)) {
      any_moved = true;
      continue;
    }
    if (!postponed) // a body that exceeds the work alone must not block the others
      first_moving_ = any_moved ? i : i + 1;
    postponed = true;
    slot.pose = slot.before;
    slot.glide_elapsed_ticks -= 1;
  }
}

/// False when the work did not suffice; the proxy and the obstacle are then unchanged.
bool SceneModel::move_body(std::size_t index, bool holds, WorkLimit& work) noexcept {
  constexpr int kCrossingWork = 10;
  const Slot& slot = slots_[index];
  const Vec3 local_before = slot.before.to_local(proxy_);
  Vec3 target = proxy_;
  Touch face; // the face that pushes, in the previous pose
  bool pushed = holds;
  if (holds) {
    target = slot.pose.to_world(local_before);
  } else {
    const Vec3 local_after = slot.pose.to_local(proxy_);
    work.spend(kCrossingWork);
    const auto hit = crossing(slot.body->shape, tool_radius_m_, local_before, local_after, work);
    pushed = hit.has_value();
    if (hit) {
      const Vec3 point = local_before + (local_after - local_before) * hit->fraction;
      target = slot.pose.to_world(point + hit->normal * Proxy::kSkin_m);
      face = {index, slot.before.to_world(point), slot.before.rotation.rotated(hit->normal), 0};
    }
  }
  if (pushed) {
    // If another body is in the path, the proxy stops there and the moving body passes over it.
    const Proxy::Stop stop = Proxy::sweep(
        proxy_, target, {{near_bodies_.data(), near_body_count_}, tool_radius_m_, work}, index);
    if (stop.complete)
      proxy_ = stop.hit ? proxy_ + (target - proxy_) * (stop.fraction * (1 - 1e-9)) : target;
  }
  if (work.exhausted())
    return false;
  if (pushed && !holds)
    touches_.add(face);
  Obstacle& obstacle = near_bodies_[near_body_index_[index]];
  obstacle.pose = slot.pose;
  obstacle.bounds = bounds_of(slot.body->shape, slot.pose);
  return true;
}

} // namespace tactus::haptic

#include "core/haptic/scene/scene_model.hpp"

/// SceneModel's proxy; scene_force.cpp has the force, scene_events.cpp the events.
namespace tactus::haptic {
namespace {

constexpr double kMaxPosition_m = 1e3;
constexpr double kMaxSpeed_m_per_s = 1e4;

} // namespace

Vec3 SceneModel::force(const Tick& tick, const State& state) noexcept {
  if (!is_finite(state.position))
    return {};
  take_scene(tick);
  const Vec3 goal = limited(state.position, kMaxPosition_m);
  const Vec3 velocity = limited(state.velocity, kMaxSpeed_m_per_s);
  for (std::size_t i = 0; i < count_; ++i)
    glide(slots_[i]);
  if (!started_) {
    proxy_ = goal;
    previous_velocity_ = velocity;
    touches_.count = 0;
    started_ = true;
  }
  // Half of the work is reserved for the contact and a quarter for motions. So bodies that appear
  // do not stop the motion of other bodies, and neither stops the contact.
  WorkLimit appearing(work_per_tick_ / 4);
  resolve_overlaps(tick, appearing);
  find_near_bodies(goal);
  WorkLimit moving(work_per_tick_ / 4 + std::max<std::int64_t>(appearing.remaining(), 0));
  move_bodies(moving);
  WorkLimit work(work_per_tick_ / 2 + std::max<std::int64_t>(moving.remaining(), 0));
  if (near_body_count_ == 0) {
    proxy_ = goal;
    touches_.count = 0;
    complete_ = true;
    max_motion_m_ = kUnlimitedMotion;
  } else {
    follow(goal, work);
  }
  const Vec3 force = render(tick, goal, velocity);
  push_events(tick);
  previous_velocity_ = velocity;
  return force;
}

/// Collects the bodies that the proxy can reach in this tick. Those that it touches come first:
/// their faces shorten a motion, so that bodies behind them need no exact test. The proxy stays
/// within |proxy - goal| of its goals, and friction moves the goals by at most the same distance.
void SceneModel::find_near_bodies(const Vec3& goal) noexcept {
  double reach = 3.0 * norm(proxy_ - goal) + 1e-6;
  for (const Slot& slot : slots())
    if (slot.moved()) // the body may take the proxy along
      reach += 3.0 * norm(slot.pose.to_world(slot.before.to_local(proxy_)) - proxy_);
  near_body_count_ = 0;
  std::fill_n(near_body_index_.begin(), count_, Proxy::kNoSlot);
  const auto add = [&](std::size_t i) {
    const Slot& slot = slots_[i];
    if (near_body_index_[i] != Proxy::kNoSlot ||
        (!slot.moved() &&
         distance_lower_bound(slot.body->shape, slot.pose.to_local(goal)) - tool_radius_m_ > reach))
      return;
    near_body_index_[i] = near_body_count_;
    near_bodies_[near_body_count_++] = {slot.body, slot.pose, i,
                                        bounds_of(slot.body->shape, slot.pose)};
  };
  for (const Touch& touch : touches_.all())
    add(touch.slot);
  for (std::size_t i = 0; i < count_; ++i)
    add(i);
}

/// The faces that held the proxy in the last tick, moved with their bodies.
Touches SceneModel::moved_touches() const noexcept {
  Touches result = touches_;
  for (std::size_t i = 0; i < result.count; ++i) {
    Touch& touch = result.touch[i];
    const Slot& slot = slots_[touch.slot];
    if (slot.moved()) {
      touch.normal =
          slot.pose.rotation.rotated(slot.before.rotation.inverse().rotated(touch.normal));
      touch.point = slot.pose.to_world(slot.before.to_local(touch.point));
    }
  }
  return result;
}

/// Moves the proxy to the nearest point to the handle that the faces and their friction allow.
void SceneModel::follow(const Vec3& goal, WorkLimit& work) noexcept {
  const Surroundings surroundings{near_bodies(), tool_radius_m_, work};
  const double distance = norm(goal - proxy_);
  const bool shortened = distance > max_motion_m_;
  const Vec3 target = shortened ? proxy_ + (goal - proxy_) * (max_motion_m_ / distance) : goal;
  const Proxy::Result found =
      Proxy::settle(proxy_, target, surroundings, complete_ ? moved_touches() : Touches{});
  complete_ = found.complete && !shortened;
  if (!complete_)
    return keep_incomplete(found, goal, shortened ? max_motion_m_ : distance);
  max_motion_m_ = kUnlimitedMotion;
  proxy_ = found.end;
  touches_ = found.touches;
}

/// Uses a result for which the work did not suffice: the proxy has moved only part of the distance.
/// Its faces carry the whole distance to the handle. After little progress the next tick tries a
/// shorter motion, which costs less, and then longer ones again.
void SceneModel::keep_incomplete(const Proxy::Result& result, const Vec3& goal,
                                 double attempted_m) noexcept {
  constexpr double kMinMotion_m = 1e-7;
  if (result.complete)
    max_motion_m_ *= 4.0;
  else if (norm(result.end - proxy_) < attempted_m / 8)
    max_motion_m_ = std::max(attempted_m / 4, kMinMotion_m);
  // Without a motion the old faces still hold the proxy.
  Touches faces =
      result.complete || result.hit || !(result.end == proxy_) ? result.touches : moved_touches();
  if (faces.solve_penetration(goal))
    touches_ = faces;
  proxy_ = result.end;
}

} // namespace tactus::haptic

#include "core/haptic/scene/scene_model.hpp"

/// SceneModel's proxy; scene_force.cpp has the force, scene_events.cpp the events.
namespace tactus::haptic {
namespace {

constexpr double kMaxPosition_m = 1e3;
constexpr double kMaxSpeed_m_per_s = 1e4;
constexpr int kFrictionRounds = 6;

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
  // Half of the work is reserved for the contact and a quarter for motions: bodies that appear do
  // not stop the motion of others, and neither stops the contact.
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
  } else if (!sticks(goal)) {
    slide(goal, work);
  }
  const Vec3 force = render(tick, goal, velocity);
  push_events(tick);
  previous_velocity_ = velocity;
  return force;
}

/// Collects the bodies that the proxy can reach in this tick. Those that it touches come first:
/// their faces shorten a motion, so that bodies behind them need no exact test. The proxy stays
/// within |proxy - goal| of its goals, and friction moves these by no more than that again.
void SceneModel::find_near_bodies(const Vec3& goal) noexcept {
  double reach = 3.0 * norm(proxy_ - goal) + 1e-6;
  for (const Slot& slot : slots())
    if (slot.moved()) // it may move the proxy along
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

double SceneModel::friction_of(const Touches& touches) const noexcept {
  double weight = 0, sum = 0;
  for (const Touch& touch : touches.all()) {
    const Material& material = slots_[touch.slot].body->material;
    const double normal_force = material.stiffness_n_per_m * touch.penetration_m;
    weight += normal_force;
    sum += normal_force * material.friction;
  }
  return weight > 0.0 ? sum / weight : 0.0;
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

/// Whether the handle is within the friction cone of the faces that hold the proxy. The proxy then
/// does not move.
bool SceneModel::sticks(const Vec3& goal) noexcept {
  if (touches_.count == 0 || !complete_)
    return false;
  Touches held = moved_touches();
  std::array<HalfSpace, 3> faces{};
  for (std::size_t i = 0; i < held.count; ++i)
    faces[i] = {held.touch[i].normal, dot(held.touch[i].normal, proxy_)};
  const auto nearest = nearest_point({faces.data(), held.count}, goal);
  if (!nearest)
    return false;
  for (std::size_t i = 0; i < held.count; ++i)
    held.touch[i].penetration_m = nearest->multiplier[i];
  const double friction = friction_of(held);
  if (!(friction > 0.0) || !(norm(proxy_ - nearest->point) <= friction * norm(held.normal_part())))
    return false;
  touches_ = held;
  return true;
}

/// Moves the proxy to the nearest point to the handle that the faces allow, less the distance that
/// friction holds it back.
void SceneModel::slide(const Vec3& goal, WorkLimit& work) noexcept {
  const Surroundings surroundings{{near_bodies_.data(), near_body_count_}, tool_radius_m_, work};
  const double distance = norm(goal - proxy_);
  const bool shortened = distance > max_motion_m_;
  const Vec3 target = shortened ? proxy_ + (goal - proxy_) * (max_motion_m_ / distance) : goal;
  const Proxy::Result smooth = Proxy::settle(proxy_, target, surroundings);
  complete_ = smooth.complete && !shortened;
  if (!complete_)
    return keep_incomplete(smooth, goal, shortened ? max_motion_m_ : distance);
  max_motion_m_ = kUnlimitedMotion;
  const Proxy::Result found = apply_friction(smooth, goal, surroundings);
  proxy_ = found.end;
  touches_ = found.touches;
}

/// Uses a result for which the work did not suffice: the proxy has moved a part of the way. Its
/// faces carry the whole distance to the handle. After little progress the next tick tries a
/// shorter motion, which costs less, and then longer ones again.
void SceneModel::keep_incomplete(const Proxy::Result& result, const Vec3& goal,
                                 double attempted_m) noexcept {
  constexpr double kMinMotion_m = 1e-7;
  if (result.complete)
    max_motion_m_ *= 4.0;
  else if (norm(result.end - proxy_) < attempted_m / 8)
    max_motion_m_ = std::max(attempted_m / 4, kMinMotion_m);
  // Without a new face the old ones still hold the proxy.
  Touches faces = result.complete || result.hit ? result.touches : moved_touches();
  if (faces.solve_penetration(goal))
    touches_ = faces;
  proxy_ = result.end;
}

/// The same with friction: the goal is shifted towards the proxy's last position until the
/// tangential force is mu times the normal force. On flat faces one round is exact. On curved faces
/// the normal turns along the path, and the length of the shift is found by iteration. When the
/// work is exhausted the last complete round counts.
Proxy::Result SceneModel::apply_friction(const Proxy::Result& smooth, const Vec3& goal,
                                         const Surroundings& surroundings) const noexcept {
  Proxy::Result found = smooth;
  const double friction = friction_of(found.touches);
  if (!(friction > 0.0))
    return found;
  const Vec3 normal_part = found.touches.normal_part();
  const Vec3 anchor = touches_.count > 0 ? proxy_ : found.first.point;
  const Vec3 back = without_component(anchor - found.end, normal_part);
  const double max_length = norm(back);
  double length = std::min(max_length, friction * norm(normal_part));
  for (int round = 0; round < kFrictionRounds && length > 0.0; ++round) {
    const Vec3 friction_offset = back * (length / max_length);
    const Proxy::Result slid = Proxy::settle(proxy_, goal + friction_offset, surroundings);
    if (!slid.complete || slid.touches.count == 0)
      break; // without touches the proxy has left over an edge
    found = slid;
    // The resulting tangential force against the one that the cone allows, at the new normal.
    const Vec3 spring = slid.end - goal, along = slid.touches.normal_part();
    const double drag = norm(without_component(spring, along));
    const double normal_force = dot(spring, along) / norm(along); // both over k
    if (!(drag > 0.0) || !(normal_force > 0.0))
      break;
    const double next =
        std::min(max_length, length * friction_of(slid.touches) * normal_force / drag);
    if (std::abs(next - length) <= 1e-9 * length)
      break;
    length = next;
  }
  return found;
}

} // namespace tactus::haptic

#include "core/haptic/scene/scene_model.hpp"

/// Contact between the handle and the bodies near it.
namespace tactus::haptic {
namespace {

constexpr double kFarthest_m = 1e3;
constexpr double kFastest_m_per_s = 1e4;
constexpr int kFrictionRounds = 6;

Vec3 pushed(const Touches& touches) noexcept {
  Vec3 sum;
  for (const Touch& touch : touches.all())
    sum += touch.normal * touch.push_m;
  return sum;
}

/// What is left of a way when its part along another is taken off.
Vec3 across(const Vec3& way, const Vec3& along) noexcept {
  const double length = norm(along);
  if (!(length > 0.0))
    return way;
  const Vec3 unit = along * (1.0 / length);
  return way - unit * dot(way, unit);
}

} // namespace

Vec3 SceneModel::force(const Tick& tick, const State& state) noexcept {
  if (!is_finite(state.position))
    return {};
  take_scene(tick);
  const Vec3 goal = limited(state.position, kFarthest_m);
  const Vec3 velocity = limited(state.velocity, kFastest_m_per_s);
  for (std::size_t i = 0; i < count_; ++i)
    glide(slots_[i]);
  if (!started_) {
    proxy_ = goal;
    velocity_before_ = velocity;
    touches_.count = 0;
    started_ = true;
  }
  emerge(tick);
  look_around(goal);
  carry();

  if (near_count_ == 0) {
    proxy_ = goal;
    touches_.count = 0;
  } else if (!sticks(goal)) {
    slide(goal);
  }
  const Vec3 force = render(tick, goal, velocity);
  notice(tick, goal);
  velocity_before_ = velocity;
  return force;
}

/// The bodies that the proxy can meet in this tick. It stays within |proxy - goal| of its goals,
/// and friction moves these by no more than that again.
void SceneModel::look_around(const Vec3& goal) noexcept {
  double reach = 3.0 * norm(proxy_ - goal) + 1e-6;
  for (const Slot& slot : slots())
    if (slot.moved()) // what it carries goes along
      reach += 3.0 * norm(slot.pose.to_world(slot.before.to_local(proxy_)) - proxy_);
  near_count_ = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Slot& slot = slots_[i];
    if (at_least_away(slot.body->shape, slot.pose.to_local(goal)) <= reach)
      near_[near_count_++] = {slot.body, slot.pose, i};
  }
}

double SceneModel::friction_of(const Touches& touches) const noexcept {
  double weight = 0, sum = 0;
  for (const Touch& touch : touches.all()) {
    const Material& material = slots_[touch.slot].body->material;
    const double here = material.stiffness_n_per_m * touch.push_m;
    weight += here;
    sum += here * material.friction;
  }
  return weight > 0.0 ? sum / weight : 0.0;
}

/// Whether the handle lies within the friction cone below a proxy that faces already hold: then
/// the proxy does not move.
bool SceneModel::sticks(const Vec3& goal) noexcept {
  if (touches_.count == 0)
    return false;
  std::array<HalfSpace, 3> faces{};
  Touches held = touches_;
  for (std::size_t i = 0; i < held.count; ++i) {
    const Slot& slot = slots_[held.touch[i].slot];
    Touch& touch = held.touch[i];
    if (slot.moved()) {
      touch.normal = slot.pose.rotation.turned(slot.before.rotation.inverse().turned(touch.normal));
      touch.point = slot.pose.to_world(slot.before.to_local(touch.point));
    }
    faces[i] = {touch.normal, dot(touch.normal, proxy_)};
  }
  const auto nearest = nearest_point({faces.data(), held.count}, goal);
  if (!nearest)
    return false;
  for (std::size_t i = 0; i < held.count; ++i)
    held.touch[i].push_m = nearest->push[i];
  const Vec3 normal_part = pushed(held);
  const Vec3 rest = proxy_ - nearest->point;
  const double friction = friction_of(held);
  if (!(friction > 0.0) || !(norm(rest) <= friction * norm(normal_part)))
    return false;
  touches_ = held;
  return true;
}

/// The proxy goes where the faces and friction let it: as far as the nearest point to the handle,
/// less what friction holds back. On flat faces one round is exact; on curved ones the normal
/// turns along the way and the length of the held part is found again.
void SceneModel::slide(const Vec3& goal) noexcept {
  const std::span<const Obstacle> near{near_.data(), near_count_};
  const bool held = touches_.count > 0;
  Proxy::Way way = Proxy::settle(proxy_, goal, near);
  const double friction = friction_of(way.touches);
  if (friction > 0.0) {
    const Vec3 normal_part = pushed(way.touches);
    const Vec3 anchor = held ? proxy_ : way.first.point;
    const Vec3 back = across(anchor - way.end, normal_part);
    const double longest = norm(back);
    double length = std::min(longest, friction * norm(normal_part));
    for (int round = 0; round < kFrictionRounds && length > 0.0; ++round) {
      const Vec3 hold = back * (length / longest);
      const Proxy::Way slid = Proxy::settle(proxy_, goal + hold, near);
      if (slid.touches.count == 0)
        break; // over an edge: nothing to rub on
      way = slid;
      // The drag that this gives against the one that the cone allows, at the slid proxy's normal.
      const Vec3 spring = slid.end - goal, along = pushed(slid.touches);
      const double drag = norm(across(spring, along));
      const double press = dot(spring, along) / norm(along);
      if (!(drag > 0.0) || !(press > 0.0))
        break;
      const double next = std::min(longest, length * friction_of(slid.touches) * press / drag);
      if (std::abs(next - length) <= 1e-9 * length)
        break;
      length = next;
    }
  }
  proxy_ = way.end;
  touches_ = way.touches;
}

/// The spring between handle and proxy, split into the faces' normal parts, each with its body's
/// stiffness, and what friction holds, with their mean; and the dampers of the approach.
Vec3 SceneModel::render(const Tick& tick, const Vec3& goal, const Vec3& velocity) noexcept {
  std::fill_n(share_.begin(), count_, Vec3{});
  double pushes = 0, springs = 0;
  for (const Touch& touch : touches_.all()) {
    pushes += touch.push_m;
    springs += slots_[touch.slot].body->material.stiffness_n_per_m * touch.push_m;
  }
  if (!(pushes > 0.0))
    return {};
  const Vec3 dragged = (proxy_ - goal - pushed(touches_)) * (springs / pushes);
  Vec3 sum;
  for (const Touch& touch : touches_.all()) {
    Slot& slot = slots_[touch.slot];
    const Material& material = slot.body->material;
    const double depth = std::max(touch.push_m - Proxy::kSkin_m, 0.0);
    const double receding = dot(velocity - velocity_of(slot, proxy_, tick.period_s), touch.normal);
    const double spring = material.stiffness_n_per_m * depth;
    const double normal = spring + material.damping_n_s_per_m * std::max(-receding, 0.0);
    double gain = 1;
    if (slot.emerged_s >= 0) {
      const double most = kEmerging_n_per_s * std::max(tick.time_s - slot.emerged_s, 0.0);
      if (normal > most)
        gain = most / normal;
      else
        slot.emerged_s = -1;
    }
    const double part = springs > 0.0 ? material.stiffness_n_per_m * touch.push_m / springs : 0.0;
    share_[touch.slot] += (touch.normal * normal + dragged * part) * gain;
    sum += (touch.normal * normal + dragged * part) * gain;
  }
  return sum;
}

void SceneModel::notice(const Tick& tick, const Vec3& goal) noexcept {
  using Kind = ContactEvent::Kind;
  std::array<const Touch*, Scene::kMostBodies> now{};
  std::array<double, Scene::kMostBodies> depth{};
  for (const Touch& touch : touches_.all()) {
    depth[touch.slot] = std::hypot(depth[touch.slot], touch.push_m);
    if (!now[touch.slot] || touch.push_m > now[touch.slot]->push_m)
      now[touch.slot] = &touch;
  }
  for (std::size_t i = 0; i < count_; ++i) {
    Slot& slot = slots_[i];
    ContactEvent event;
    event.key = slot.key;
    event.time_s = tick.time_s;
    if (now[i]) {
      event.point = proxy_ - now[i]->normal * Proxy::kSkin_m;
      event.normal = now[i]->normal;
      slot.point = slot.pose.to_local(event.point);
      slot.normal = slot.pose.rotation.inverse().turned(event.normal);
    } else {
      event.point = slot.pose.to_world(slot.point);
      event.normal = slot.pose.rotation.turned(slot.normal);
    }
    if (now[i] && !slot.touching) {
      const Vec3 v = velocity_before_ - velocity_of(slot, event.point, tick.period_s);
      event.approach_m_per_s = -dot(v, event.normal);
      event.slip_m_per_s = norm(across(v, event.normal));
      if (slot.armed && slot.emerged_s < 0 && event.approach_m_per_s >= kSlowestHit_m_per_s)
        events_.push(event);
      slot.armed = false;
      slot.reported_s = -1e9;
    }
    if (now[i] && tick.time_s - slot.reported_s >= kContactEvery_s - 1e-9) {
      event.kind = Kind::kContact;
      event.depth_m = depth[i];
      event.force_n = share_[i];
      events_.push(event);
      slot.reported_s = tick.time_s;
    }
    if (!now[i] && slot.touching) {
      event.kind = Kind::kRelease;
      events_.push(event);
      slot.released_s = tick.time_s;
      slot.emerged_s = -1;
    }
    slot.touching = now[i] != nullptr;
    if (!slot.touching && !slot.armed &&
        (tick.time_s - slot.released_s >= kRearm_s ||
         dot(goal - event.point, event.normal) >= kRearm_m))
      slot.armed = true;
  }
}

} // namespace tactus::haptic

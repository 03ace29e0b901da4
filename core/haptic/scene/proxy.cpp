#include "core/haptic/scene/proxy.hpp"

namespace tactus::haptic {
namespace {

constexpr int kMaxPasses =
    12;                      // each follows a curved or finely meshed surface by one tangent plane
constexpr int kMaxFaces = 6; // faces found in one pass
constexpr double kConverged_m = 1e-13;
constexpr double kBoundsMargin_m = 1e-9; // far above the rounding of a rotated box

// Costs in units of WorkLimit.
constexpr int kBoundsWork = 1, kCrossingWork = 10, kNearestWork = 6;

HalfSpace half_space(const Touch& touch) noexcept {
  return {touch.normal, dot(touch.normal, touch.point) + Proxy::kSkin_m};
}

/// Faces collected in one pass, with room for one candidate more than can be active.
struct Faces {
  std::array<Touch, kMaxHalfSpaces> touch{};
  std::array<HalfSpace, kMaxHalfSpaces> half{};
  std::size_t count = 0;

  void add(const Touch& hit) noexcept {
    touch[count] = hit;
    half[count++] = half_space(hit);
  }
  void keep_active(const NearestPoint& nearest) noexcept {
    std::size_t active = 0;
    for (std::size_t i = 0; i < count; ++i)
      if (nearest.multiplier[i] > 0.0) {
        touch[active] = touch[i];
        touch[active].penetration_m = nearest.multiplier[i];
        half[active++] = half[i];
      }
    count = active;
  }
};

const Obstacle* find(std::span<const Obstacle> obstacles, std::size_t slot) noexcept {
  for (const Obstacle& obstacle : obstacles)
    if (obstacle.slot == slot)
      return &obstacle;
  return nullptr;
}

/// On a single curved face the nearest point to the goal has a closed form: moves the proxy there.
/// The motion is a chord through the body itself, which is therefore left out of the sweep. Where
/// that is not possible nothing changes.
void follow_curve(Vec3& proxy, const Vec3& goal, Faces& faces,
                  const Surroundings& surroundings) noexcept {
  Touch& touch = faces.touch[0];
  const Obstacle* obstacle = find(surroundings.obstacles, touch.slot);
  if (!obstacle)
    return;
  const auto nearest = nearest_on_curve(obstacle->body->shape, surroundings.tool_radius_m,
                                        obstacle->pose.rotation.inverse().rotated(touch.normal),
                                        obstacle->pose.to_local(goal));
  if (!nearest)
    return;
  const Vec3 normal = obstacle->pose.rotation.rotated(nearest->normal);
  const Vec3 point = obstacle->pose.to_world(nearest->point);
  const Vec3 end = point + normal * Proxy::kSkin_m;
  const double distance = norm(end - goal);
  if (distance > norm(proxy - goal) + kConverged_m)
    return;
  const Proxy::Stop stop = Proxy::sweep(proxy, end, surroundings, touch.slot);
  if (stop.hit || !stop.complete)
    return;
  touch.normal = normal;
  touch.point = point;
  touch.penetration_m = distance;
  proxy = end;
}

} // namespace

bool Touches::solve_penetration(const Vec3& goal) noexcept {
  std::array<HalfSpace, 3> faces{};
  for (std::size_t i = 0; i < count; ++i)
    faces[i] = half_space(touch[i]);
  const auto nearest = nearest_point({faces.data(), count}, goal);
  if (!nearest)
    return false;
  for (std::size_t i = 0; i < count; ++i)
    touch[i].penetration_m = nearest->multiplier[i];
  return true;
}

Proxy::Stop Proxy::sweep(const Vec3& from, const Vec3& to, const Surroundings& surroundings,
                         std::size_t except) noexcept {
  Stop stop;
  const Segment segment(from, to);
  const double margin = surroundings.tool_radius_m + kBoundsMargin_m;
  for (const Obstacle& obstacle : surroundings.obstacles) {
    if (obstacle.slot == except)
      continue;
    surroundings.work.spend(kBoundsWork);
    if (segment.entry(obstacle.bounds, margin, stop.fraction) == Segment::kNever)
      continue;
    surroundings.work.spend(kCrossingWork);
    const auto found =
        crossing(obstacle.body->shape, surroundings.tool_radius_m, obstacle.pose.to_local(from),
                 obstacle.pose.to_local(to), surroundings.work);
    if (surroundings.work.exhausted())
      break;
    // Of two met at the same fraction the one with the lower slot counts, whatever the order of the
    // tests.
    if (!found ||
        (stop.hit && (found->fraction > stop.fraction ||
                      (found->fraction == stop.fraction && obstacle.slot > stop.touch.slot))))
      continue;
    stop.fraction = found->fraction;
    stop.hit = true;
    stop.touch.slot = obstacle.slot;
    stop.touch.normal = obstacle.pose.rotation.rotated(found->normal);
    stop.touch.point = from + (to - from) * found->fraction;
  }
  stop.complete = !surroundings.work.exhausted();
  return stop;
}

Proxy::Result Proxy::settle(const Vec3& start, const Vec3& goal,
                            const Surroundings& surroundings) noexcept {
  Result result;
  Vec3 proxy = start;
  Faces faces, before_faces;
  for (int pass = 0; pass < kMaxPasses && result.complete; ++pass) {
    const Vec3 before = proxy;
    before_faces = faces;
    faces.count = 0;
    for (int step = 0; step < kMaxFaces; ++step) {
      surroundings.work.spend(kNearestWork << faces.count);
      const auto nearest = nearest_point({faces.half.data(), faces.count}, goal);
      if (!nearest)
        break;
      faces.keep_active(*nearest);
      const Vec3 target = nearest->point;
      const Stop stop = sweep(proxy, target, surroundings);
      if (!stop.complete) {
        result.complete = false;
        break;
      }
      if (!stop.hit) {
        proxy = target;
        break;
      }
      if (!result.hit) {
        result.hit = true;
        result.first = stop.touch;
      }
      // Back along the motion to the distance kSkin_m above the face.
      const Vec3 motion = target - proxy;
      const double approach = -dot(motion, stop.touch.normal);
      const double back = approach > 0.0 ? kSkin_m / approach : 0.0;
      proxy += motion * std::max(stop.fraction - back, 0.0);
      if (faces.count == kMaxHalfSpaces)
        break;
      faces.add(stop.touch);
    }
    if (!result.complete)
      break;
    if (faces.count == 1)
      follow_curve(proxy, goal, faces, surroundings);
    if (faces.count == 0 || norm(proxy - before) <= kConverged_m)
      break;
  }
  if (faces.count == 0 && !result.complete)
    faces = before_faces; // of the last pass: they still lie between proxy and goal
  result.end = proxy;
  for (std::size_t i = 0; i < faces.count && result.touches.count < 3; ++i)
    if (faces.touch[i].penetration_m > kSkin_m)
      result.touches.touch[result.touches.count++] = faces.touch[i];
  return result;
}

} // namespace tactus::haptic

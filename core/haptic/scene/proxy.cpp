#include "core/haptic/scene/proxy.hpp"

namespace tactus::haptic {
namespace {

constexpr int kPasses = 12; // a curved or finely meshed surface is followed tangent by tangent
constexpr int kSteps = 6;   // faces met in one pass
constexpr double kAtRest_m = 1e-13;
constexpr double kBoundsMargin_m = 1e-9; // far above the rounding of a turned box

// What things cost, in units of WorkLimit.
constexpr int kBoundsWork = 1, kCrossingWork = 10, kNearestWork = 6;

HalfSpace half_space(const Touch& touch) noexcept {
  return {touch.normal, dot(touch.normal, touch.point) + Proxy::kSkin_m};
}

/// Faces collected in one pass, with room for one candidate more than can hold.
struct Faces {
  std::array<Touch, kMaxHalfSpaces> touch{};
  std::array<HalfSpace, kMaxHalfSpaces> half{};
  std::size_t count = 0;

  void add(const Touch& met) noexcept {
    touch[count] = met;
    half[count++] = half_space(met);
  }
  void keep_pushing(const NearestPoint& nearest) noexcept {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i)
      if (nearest.push[i] > 0.0) {
        touch[kept] = touch[i];
        touch[kept].push_m = nearest.push[i];
        half[kept++] = half[i];
      }
    count = kept;
  }
};

const Obstacle* find(std::span<const Obstacle> obstacles, std::size_t slot) noexcept {
  for (const Obstacle& obstacle : obstacles)
    if (obstacle.slot == slot)
      return &obstacle;
  return nullptr;
}

/// A lone curved face is exact in one move: along the surface to the point nearest to the goal.
/// The motion along it is a chord through its own body, which is left out of the sweep. Nothing
/// changes where that is not possible.
void follow_curve(Vec3& proxy, const Vec3& goal, Faces& faces,
                  const Surroundings& around) noexcept {
  Touch& touch = faces.touch[0];
  const Obstacle* obstacle = find(around.obstacles, touch.slot);
  if (!obstacle)
    return;
  const auto nearest = nearest_on_curve(obstacle->body->shape, around.tool_radius_m,
                                        obstacle->pose.rotation.inverse().turned(touch.normal),
                                        obstacle->pose.to_local(goal));
  if (!nearest)
    return;
  const Vec3 normal = obstacle->pose.rotation.turned(nearest->normal);
  const Vec3 point = obstacle->pose.to_world(nearest->point);
  const Vec3 end = point + normal * Proxy::kSkin_m;
  const double push = norm(end - goal);
  if (push > norm(proxy - goal) + kAtRest_m)
    return;
  const Proxy::Stop stop = Proxy::sweep(proxy, end, around, touch.slot);
  if (stop.met || !stop.complete)
    return;
  touch.normal = normal;
  touch.point = point;
  touch.push_m = push;
  proxy = end;
}

} // namespace

bool Touches::press(const Vec3& goal) noexcept {
  std::array<HalfSpace, 3> faces{};
  for (std::size_t i = 0; i < count; ++i)
    faces[i] = half_space(touch[i]);
  const auto nearest = nearest_point({faces.data(), count}, goal);
  if (!nearest)
    return false;
  for (std::size_t i = 0; i < count; ++i)
    touch[i].push_m = nearest->push[i];
  return true;
}

Proxy::Stop Proxy::sweep(const Vec3& from, const Vec3& to, const Surroundings& around,
                         std::size_t except) noexcept {
  Stop stop;
  const Segment segment(from, to);
  const double margin = around.tool_radius_m + kBoundsMargin_m;
  for (const Obstacle& obstacle : around.obstacles) {
    if (obstacle.slot == except)
      continue;
    around.work.spend(kBoundsWork);
    if (segment.entry(obstacle.bounds, margin, stop.fraction) == Segment::kNever)
      continue;
    around.work.spend(kCrossingWork);
    const auto found =
        crossing(obstacle.body->shape, around.tool_radius_m, obstacle.pose.to_local(from),
                 obstacle.pose.to_local(to), around.work);
    if (around.work.exhausted())
      break;
    // Of two that are met at once it is the one with the lower slot, in whatever order they are
    // tested.
    if (!found ||
        (stop.met && (found->fraction > stop.fraction ||
                      (found->fraction == stop.fraction && obstacle.slot > stop.touch.slot))))
      continue;
    stop.fraction = found->fraction;
    stop.met = true;
    stop.touch.slot = obstacle.slot;
    stop.touch.normal = obstacle.pose.rotation.turned(found->normal);
    stop.touch.point = from + (to - from) * found->fraction;
  }
  stop.complete = !around.work.exhausted();
  return stop;
}

Proxy::Result Proxy::settle(const Vec3& start, const Vec3& goal,
                            const Surroundings& around) noexcept {
  Result result;
  Vec3 proxy = start;
  Faces faces, before_faces;
  for (int pass = 0; pass < kPasses && result.complete; ++pass) {
    const Vec3 before = proxy;
    before_faces = faces;
    faces.count = 0;
    for (int step = 0; step < kSteps; ++step) {
      around.work.spend(kNearestWork << faces.count);
      const auto nearest = nearest_point({faces.half.data(), faces.count}, goal);
      if (!nearest)
        break;
      faces.keep_pushing(*nearest);
      const Vec3 target = nearest->point;
      const Stop stop = sweep(proxy, target, around);
      if (!stop.complete) {
        result.complete = false;
        break;
      }
      if (!stop.met) {
        proxy = target;
        break;
      }
      if (!result.met) {
        result.met = true;
        result.first = stop.touch;
      }
      // Back along the motion until it is a skin's thickness above the face.
      const Vec3 motion = target - proxy;
      const double sinking = -dot(motion, stop.touch.normal);
      const double back = sinking > 0.0 ? kSkin_m / sinking : 0.0;
      proxy += motion * std::max(stop.fraction - back, 0.0);
      if (faces.count == kMaxHalfSpaces)
        break;
      faces.add(stop.touch);
    }
    if (!result.complete)
      break;
    if (faces.count == 1)
      follow_curve(proxy, goal, faces, around);
    if (faces.count == 0 || norm(proxy - before) <= kAtRest_m)
      break;
  }
  if (faces.count == 0 && !result.complete)
    faces = before_faces; // of the pass before: they still lie between the proxy and the goal
  result.end = proxy;
  for (std::size_t i = 0; i < faces.count && result.touches.count < 3; ++i)
    if (faces.touch[i].push_m > kSkin_m)
      result.touches.touch[result.touches.count++] = faces.touch[i];
  return result;
}

} // namespace tactus::haptic

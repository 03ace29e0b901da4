#include "core/haptic/scene/proxy.hpp"

namespace tactus::haptic {
namespace {

constexpr int kPasses = 12; // a curved or finely meshed surface is followed tangent by tangent
constexpr int kSteps = 6;   // faces met in one pass
constexpr double kAtRest_m = 1e-13;

HalfSpace half_space(const Touch& touch) noexcept {
  return {touch.normal, dot(touch.normal, touch.point) + Proxy::kSkin_m};
}

/// Faces collected in one pass, with room for one candidate more than can hold.
struct Faces {
  std::array<Touch, kMostHalfSpaces> touch{};
  std::array<HalfSpace, kMostHalfSpaces> half{};
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
/// The way along it is a chord through its own body, which is left out of the sweep.
bool follow_curve(Vec3& proxy, const Vec3& goal, Faces& faces,
                  std::span<const Obstacle> obstacles) noexcept {
  Touch& touch = faces.touch[0];
  const Obstacle* obstacle = find(obstacles, touch.slot);
  if (!obstacle)
    return false;
  const auto nearest = nearest_on_curve(obstacle->body->shape,
                                        obstacle->pose.rotation.inverse().turned(touch.normal),
                                        obstacle->pose.to_local(goal));
  if (!nearest)
    return false;
  const Vec3 normal = obstacle->pose.rotation.turned(nearest->normal);
  const Vec3 point = obstacle->pose.to_world(nearest->point);
  const Vec3 end = point + normal * Proxy::kSkin_m;
  const double push = norm(end - goal);
  if (push > norm(proxy - goal) + kAtRest_m || Proxy::sweep(proxy, end, obstacles, touch.slot).met)
    return false;
  touch.normal = normal;
  touch.point = point;
  touch.push_m = push;
  proxy = end;
  return true;
}

} // namespace

Proxy::Stop Proxy::sweep(const Vec3& from, const Vec3& to, std::span<const Obstacle> obstacles,
                         std::size_t except) noexcept {
  Stop stop;
  for (const Obstacle& obstacle : obstacles) {
    if (obstacle.slot == except)
      continue;
    const auto found =
        crossing(obstacle.body->shape, obstacle.pose.to_local(from), obstacle.pose.to_local(to));
    if (!found || (stop.met && found->share >= stop.share))
      continue;
    stop.share = found->share;
    stop.met = true;
    stop.touch.slot = obstacle.slot;
    stop.touch.normal = obstacle.pose.rotation.turned(found->normal);
    stop.touch.point = from + (to - from) * found->share;
  }
  return stop;
}

Proxy::Way Proxy::settle(const Vec3& start, const Vec3& goal,
                         std::span<const Obstacle> obstacles) noexcept {
  Way way;
  Vec3 proxy = start;
  Faces faces;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Vec3 before = proxy;
    faces.count = 0;
    for (int step = 0; step < kSteps; ++step) {
      const auto nearest = nearest_point({faces.half.data(), faces.count}, goal);
      if (!nearest)
        break;
      faces.keep_pushing(*nearest);
      const Vec3 target = nearest->point;
      const Stop stop = sweep(proxy, target, obstacles);
      if (!stop.met) {
        proxy = target;
        break;
      }
      if (!way.met) {
        way.met = true;
        way.first = stop.touch;
      }
      // Back along the way until it is a skin's thickness above the face.
      const Vec3 move = target - proxy;
      const double sinking = -dot(move, stop.touch.normal);
      const double back = sinking > 0.0 ? kSkin_m / sinking : 0.0;
      proxy += move * std::max(stop.share - back, 0.0);
      if (faces.count == kMostHalfSpaces)
        break;
      faces.add(stop.touch);
    }
    if (faces.count == 1)
      follow_curve(proxy, goal, faces, obstacles);
    if (faces.count == 0 || norm(proxy - before) <= kAtRest_m)
      break;
  }
  way.end = proxy;
  for (std::size_t i = 0; i < faces.count && way.touches.count < 3; ++i)
    if (faces.touch[i].push_m > kSkin_m)
      way.touches.touch[way.touches.count++] = faces.touch[i];
  return way;
}

} // namespace tactus::haptic

#include "core/haptic/scene/proxy.hpp"

#include <limits>
#include <utility>

namespace tactus::haptic {
namespace {

/// Each pass follows a curved or finely meshed surface by one tangent plane.
constexpr int kMaxPasses = 32;
constexpr int kMaxFaces = 6; // faces found in one pass
constexpr double kConverged_m = 1e-13;
constexpr double kSlipTolerance = 1e-7; // share of the friction force; the proxy counts as stuck
                                        // within it
constexpr double kLastPart = 0.01, kMaxFactor = 0.7; // shares of the slip: see settle()
constexpr double kResting_m = 1e-9;      // distance within which the proxy lies on a face
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
  [[nodiscard]] double penetration_m() const noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i)
      sum += touch[i].penetration_m;
    return sum;
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
/// The motion is a chord through the body itself, which is therefore left out of the sweep. If that
/// is not possible, nothing changes.
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

void Touches::add(const Touch& face) noexcept {
  constexpr double kSameNormal = 1e-9;
  std::size_t i = 0;
  while (i < count &&
         (touch[i].slot != face.slot || dot(touch[i].normal, face.normal) < 1.0 - kSameNormal))
    ++i;
  if (i == touch.size())
    return;
  touch[i] = face;
  count = std::max(count, i + 1);
}

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

double friction_of(std::span<const Touch> faces, std::span<const Obstacle> obstacles) noexcept {
  double weight = 0, sum = 0;
  for (const Touch& face : faces)
    if (const Obstacle* obstacle = find(obstacles, face.slot)) {
      const Material& material = obstacle->body->material;
      const double normal_force = material.stiffness_n_per_m * face.penetration_m;
      weight += normal_force;
      sum += normal_force * material.friction;
    }
  return weight > 0.0 ? sum / weight : 0.0;
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
    // If two bodies are met at the same fraction, the one with the lower slot counts, so that the
    // order of the tests does not matter.
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

Proxy::Result Proxy::settle(const Vec3& start, const Vec3& goal, const Surroundings& surroundings,
                            const Touches& held) noexcept {
  Result result;
  Vec3 proxy = start;
  Faces faces, before_faces;
  for (const Touch& touch : held.all())
    if (std::abs(dot(touch.normal, start - touch.point)) < kResting_m) {
      faces.add(touch);
      faces.half[faces.count - 1].offset = dot(touch.normal, start);
    }
  Vec3 press; // the part of proxy - goal along the faces' normals, with friction
  double excess_before = std::numeric_limits<double>::infinity();
  bool stuck = false;
  for (int pass = 0; pass < kMaxPasses && result.complete && !stuck; ++pass) {
    const Vec3 before = proxy;
    before_faces = faces;
    if (pass > 0)
      faces.count = 0;
    double friction = 0;
    for (int step = 0; step < kMaxFaces; ++step) {
      Vec3 target = goal;
      // After a step along a curved surface a proxy with friction is above the face: the proxy
      // moves straight down to the face, not sideways.
      const bool down = faces.count == 0 && (press.x != 0.0 || press.y != 0.0 || press.z != 0.0);
      if (down) {
        target = proxy - std::exchange(press, Vec3{});
      } else {
        surroundings.work.spend(kNearestWork << faces.count);
        const auto nearest = nearest_point({faces.half.data(), faces.count}, goal);
        if (!nearest)
          break;
        faces.keep_active(*nearest);
        target = nearest->point;
        friction = friction_of({faces.touch.data(), faces.count}, surroundings.obstacles);
        if (friction > 0.0) {
          press = target - goal;
          const Vec3 along = target - proxy;
          const double length = norm(along), held_back = friction * faces.penetration_m();
          stuck = length <= held_back * (1.0 + kSlipTolerance);
          if (stuck)
            break;
          // On a curved surface the remaining slip changes by one factor from pass to pass. A small
          // remainder is taken at once, as the sum of that geometric series. If the slip grows, the
          // search is not near its end.
          double excess = length - held_back;
          const double factor = excess / excess_before, last_part = kLastPart * held_back;
          excess_before = excess;
          if (excess < last_part && factor < kMaxFactor)
            excess /= 1.0 - factor;
          else if (factor >= 1.0)
            excess = std::max(excess, std::min(last_part, length));
          target = proxy + along * (excess / length);
        }
      }
      const Stop stop = sweep(proxy, target, surroundings);
      if (!stop.complete) {
        result.complete = false;
        break;
      }
      if (!stop.hit) {
        proxy = target;
        if (down)
          continue; // past an edge
        break;
      }
      result.hit = true;
      // Back along the motion to the distance kSkin_m above the face.
      const Vec3 motion = target - proxy;
      const double approach = -dot(motion, stop.touch.normal);
      const double back = approach > 0.0 ? kSkin_m / approach : 0.0;
      proxy += motion * std::max(stop.fraction - back, 0.0);
      if (faces.count == kMaxHalfSpaces)
        break;
      faces.add(stop.touch);
    }
    if (!result.complete || stuck)
      break;
    if (faces.count == 1 && !(friction > 0.0))
      follow_curve(proxy, goal, faces, surroundings);
    if (faces.count == 0 || norm(proxy - before) <= kConverged_m)
      break;
  }
  if (faces.count == 0 && !result.complete) // keeps the faces of the last pass on which the proxy
                                            // still lies
    for (const Touch& touch : std::span(before_faces.touch.data(), before_faces.count))
      if (dot(touch.normal, proxy - touch.point) > -kResting_m)
        faces.add(touch);
  result.end = proxy;
  for (std::size_t i = 0; i < faces.count && result.touches.count < 3; ++i)
    if (faces.touch[i].penetration_m > kSkin_m)
      result.touches.touch[result.touches.count++] = faces.touch[i];
  return result;
}

} // namespace tactus::haptic

#include "core/haptic/scene/rounded_shape.hpp"

namespace tactus::haptic {
namespace {

/// -1, 0 or 1; a component no larger than the rounding of a rotation counts as 0.
int sign(double component) noexcept {
  constexpr double kRounding = 1e-9;
  return component > kRounding ? 1 : component < -kRounding ? -1 : 0;
}

/// The point at distance `radius` from `core` in the direction of `gap`, if gap is shorter.
std::optional<SurfacePoint> at_radius(const Vec3& core, const Vec3& gap, double radius) noexcept {
  const double distance = norm(gap);
  if (!(distance > 0.0 && distance < radius))
    return {};
  const Vec3 normal = gap * (1.0 / distance);
  return SurfacePoint{core + normal * radius, normal};
}

} // namespace

Vec3 nearest_point(const Box& box, const Vec3& p) noexcept {
  return {std::clamp(p.x, -box.half.x, box.half.x), std::clamp(p.y, -box.half.y, box.half.y),
          std::clamp(p.z, -box.half.z, box.half.z)};
}

Vec3 nearest_point(const Disk& disk, const Vec3& p) noexcept {
  const double r = std::sqrt(p.x * p.x + p.y * p.y),
               scale = r > disk.radius ? disk.radius / r : 1.0;
  return {p.x * scale, p.y * scale, std::clamp(p.z, -disk.half_thickness, disk.half_thickness)};
}

std::optional<SurfacePoint> nearest_on_rounding(const Box& box, double radius, const Vec3& normal,
                                                const Vec3& inside) noexcept {
  const Vec3 core = nearest_point(box, inside), gap = inside - core;
  int rounded_axes = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (sign(normal[axis]) != (gap[axis] > 0.0) - (gap[axis] < 0.0))
      return {};
    rounded_axes += gap[axis] != 0.0;
  }
  return rounded_axes > 1 ? at_radius(core, gap, radius) : std::nullopt;
}

std::optional<SurfacePoint> nearest_on_rounding(const Disk& disk, double radius, const Vec3& normal,
                                                const Vec3& inside) noexcept {
  const Vec3 core = nearest_point(disk, inside), gap = inside - core;
  const bool on_rim =
      (gap.x != 0.0 || gap.y != 0.0) && (sign(normal.x) != 0 || sign(normal.y) != 0);
  if (!on_rim || sign(normal.z) != (gap.z > 0.0) - (gap.z < 0.0))
    return {};
  return at_radius(core, gap, radius);
}

} // namespace tactus::haptic

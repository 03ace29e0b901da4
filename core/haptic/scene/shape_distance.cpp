#include "core/dsp/elementary.hpp"
#include "core/haptic/scene/rounded_shape.hpp"

/// Distances from the bare shapes and bounding boxes.
namespace tactus::haptic {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double lower_bound(const Plane&, const Vec3& p) noexcept { return p.z; }
double lower_bound(const Sphere& sphere, const Vec3& p) noexcept { return norm(p) - sphere.radius; }
double lower_bound(const Bounds& bounds, const Vec3& p) noexcept {
  double farthest = -kInfinity;
  for (int axis = 0; axis < 3; ++axis)
    farthest = std::max({farthest, bounds.low[axis] - p[axis], p[axis] - bounds.high[axis]});
  return farthest;
}
double lower_bound(const Box& box, const Vec3& p) noexcept {
  return lower_bound(Bounds{-box.half, box.half}, p);
}
double lower_bound(const Disk& disk, const Vec3& p) noexcept {
  return std::max(math::hypot(p.x, p.y) - disk.radius, std::abs(p.z) - disk.half_thickness);
}
double lower_bound(const MeshSurface& surface, const Vec3& p) noexcept {
  return lower_bound(surface.mesh->bounds(), p);
}

bool farther(const Plane& plane, const Vec3& p, double distance, WorkLimit&) noexcept {
  return lower_bound(plane, p) >= distance;
}
bool farther(const Sphere& sphere, const Vec3& p, double distance, WorkLimit&) noexcept {
  return lower_bound(sphere, p) >= distance;
}
template <class Solid>
bool farther(const Solid& solid, const Vec3& p, double distance, WorkLimit&) noexcept {
  return norm(p - nearest_point(solid, p)) >= distance;
}
bool farther(const MeshSurface& surface, const Vec3& p, double distance, WorkLimit& work) noexcept {
  return !surface.mesh->nearest(p, distance, work) && !work.exhausted();
}

/// The axis-aligned box around a rotated box: its half extents are |R| half, where |R| is the
/// elementwise absolute value.
Bounds enclosing_box(const Vec3& middle, const Vec3& half, const Pose& pose) noexcept {
  const Vec3 x = pose.rotation.rotated({half.x, 0, 0}), y = pose.rotation.rotated({0, half.y, 0}),
             z = pose.rotation.rotated({0, 0, half.z}), centre = pose.to_world(middle);
  Vec3 reach;
  for (int axis = 0; axis < 3; ++axis)
    reach[axis] = std::abs(x[axis]) + std::abs(y[axis]) + std::abs(z[axis]);
  return {centre - reach, centre + reach};
}

Bounds enclose(const Plane&, const Pose&) noexcept {
  const Vec3 everywhere{kInfinity, kInfinity, kInfinity};
  return {-everywhere, everywhere};
}
Bounds enclose(const Sphere& sphere, const Pose& pose) noexcept {
  const Vec3 reach{sphere.radius, sphere.radius, sphere.radius};
  return {pose.position - reach, pose.position + reach};
}
Bounds enclose(const Box& box, const Pose& pose) noexcept {
  return enclosing_box({}, box.half, pose);
}
Bounds enclose(const Disk& disk, const Pose& pose) noexcept {
  return enclosing_box({}, {disk.radius, disk.radius, disk.half_thickness}, pose);
}
Bounds enclose(const MeshSurface& surface, const Pose& pose) noexcept {
  const Bounds& local = surface.mesh->bounds();
  return enclosing_box((local.low + local.high) * 0.5, (local.high - local.low) * 0.5, pose);
}

} // namespace

double distance_lower_bound(const Shape& shape, const Vec3& point) noexcept {
  return std::visit([&](const auto& s) { return lower_bound(s, point); }, shape);
}

bool is_farther(const Shape& shape, const Vec3& point, double distance, WorkLimit& work) noexcept {
  return std::visit([&](const auto& s) { return farther(s, point, distance, work); }, shape);
}

Bounds bounds_of(const Shape& shape, const Pose& pose) noexcept {
  return std::visit([&](const auto& s) { return enclose(s, pose); }, shape);
}

} // namespace tactus::haptic

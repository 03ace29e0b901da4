#pragma once

#include "core/geometry/vec3.hpp"
#include "core/haptic/scene/triangle_mesh.hpp"

#include <memory>
#include <optional>
#include <variant>

/// The shapes of bodies and their collision tests, each in the body's own frame, m. shape.cpp has
/// the crossing and exit of every shape, rounded_shape.cpp boxes and disks for a tool of finite
/// radius, shape_distance.cpp distances and bounds.
namespace tactus::haptic {

/// The half space z < 0.
struct Plane {};
struct Sphere {
  double radius;
};
struct Box {
  Vec3 half; ///< half the edges
};
/// A short cylinder about the z axis, with flat faces.
struct Disk {
  double radius, half_thickness;
};
/// A triangle mesh, touched from both sides; it has no inside.
struct MeshSurface {
  std::shared_ptr<const TriangleMesh> mesh;
};
using Shape = std::variant<Plane, Sphere, Box, Disk, MeshSurface>;

/// Where the centre of a spherical tool on a straight motion first enters a shape from outside: the
/// Minkowski sum of the shape and a ball of the tool's radius (m, >= 0; 0 is a point). Nothing for
/// a motion that begins inside a solid or leaves it. Exact up to rounding; for edges, rims and
/// meshes by convex_crossing.hpp. Not valid when the work is exhausted.
[[nodiscard]] std::optional<Crossing> crossing(const Shape& shape, double tool_radius,
                                               const Vec3& from, const Vec3& to,
                                               WorkLimit& work) noexcept;

/// A point on the surface of this Minkowski sum, with the outward unit normal.
struct SurfacePoint {
  Vec3 point, normal;
};
/// The nearest position at which a tool that overlaps the shape would only touch it. Nothing
/// without an overlap. Because a mesh has no inside, the tool leaves a mesh on the side where the
/// tool's centre is.
[[nodiscard]] std::optional<SurfacePoint>
nearest_exit(const Shape& shape, double tool_radius, const Vec3& inside, WorkLimit& work) noexcept;
/// For a curved face that is touched with this outward normal: the point of the same face nearest
/// to a point inside. Nothing on flat faces, or if the nearest point belongs to another face.
[[nodiscard]] std::optional<SurfacePoint> nearest_on_curve(const Shape& shape, double tool_radius,
                                                           const Vec3& normal,
                                                           const Vec3& inside) noexcept;

/// A lower bound of the distance from the point to the shape, m; cheap to compute.
[[nodiscard]] double distance_lower_bound(const Shape& shape, const Vec3& point) noexcept;
/// True if the whole shape is at least `distance` from the point. False if the work is exhausted.
[[nodiscard]] bool is_farther(const Shape& shape, const Vec3& point, double distance,
                              WorkLimit& work) noexcept;
/// The axis-aligned box in world coordinates around the shape in this pose; infinite for a plane.
[[nodiscard]] Bounds bounds_of(const Shape& shape, const Pose& pose) noexcept;

} // namespace tactus::haptic

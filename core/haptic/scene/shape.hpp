#pragma once

#include "core/geometry/vec3.hpp"
#include "core/haptic/scene/triangle_mesh.hpp"

#include <memory>
#include <optional>
#include <variant>

/// What can be touched, each in its own frame. Metres. shape.cpp has the bare shapes, which a point
/// touches, rounded_shape.cpp those that a tool of finite radius touches, shape_distance.cpp
/// distances and bounds.
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
/// A surface that can be touched from both sides, with no inside.
struct MeshSurface {
  std::shared_ptr<const TriangleMesh> mesh;
};
using Shape = std::variant<Plane, Sphere, Box, Disk, MeshSurface>;

/// Where a spherical tool, its centre moving straight, first enters a shape from outside: where the
/// centre enters the Minkowski sum of the shape and a ball of the tool's radius (m, >= 0; 0 is a
/// point). A motion that begins inside a solid, or only leaves it, enters nothing. Rounding aside
/// exact; pure. Incomplete, and to be dropped, when it exhausts the work.
[[nodiscard]] std::optional<Crossing> crossing(const Shape& shape, double tool_radius,
                                               const Vec3& from, const Vec3& to,
                                               WorkLimit& work) noexcept;

/// A position of the tool's centre on a rounded surface with its outward direction.
struct SurfacePoint {
  Vec3 point, normal;
};
/// The position nearest to one that overlaps the shape from which it is only touched. Nothing when
/// there is no overlap. A mesh has no inside: the tool leaves on the side where its centre is.
[[nodiscard]] std::optional<SurfacePoint>
nearest_exit(const Shape& shape, double tool_radius, const Vec3& inside, WorkLimit& work) noexcept;
/// On a rounded shape's curved face, touched with that outward normal: the point of the same face
/// nearest to an inner point. Nothing on flat faces, and where the face ends before it.
[[nodiscard]] std::optional<SurfacePoint> nearest_on_curve(const Shape& shape, double tool_radius,
                                                           const Vec3& normal,
                                                           const Vec3& inside) noexcept;

/// No part of the shape is nearer to the point than this. Cheap, never too large.
[[nodiscard]] double distance_lower_bound(const Shape& shape, const Vec3& point) noexcept;
/// Whether all of the shape is at least that far from the point. False when the work runs out.
[[nodiscard]] bool is_farther(const Shape& shape, const Vec3& point, double distance,
                              WorkLimit& work) noexcept;
/// The box along the world's axes that encloses the shape there; infinite for a plane.
[[nodiscard]] Bounds bounds_of(const Shape& shape, const Pose& pose) noexcept;

} // namespace tactus::haptic

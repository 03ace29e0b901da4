#pragma once

#include "core/haptic/scene/triangle_mesh.hpp"
#include "core/haptic/vec3.hpp"

#include <memory>
#include <optional>
#include <variant>

/// What can be touched, each in its own frame. Metres.
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

/// Where a way from one point to another first enters a shape from outside. A way that begins
/// inside a solid, or only leaves it, enters nothing. Rounding aside exact; pure.
[[nodiscard]] std::optional<Crossing> crossing(const Shape& shape, const Vec3& from,
                                               const Vec3& to) noexcept;

/// A place on the surface with its outward direction.
struct SurfacePoint {
  Vec3 point, normal;
};
/// The point of the surface nearest to an inner point; nothing outside or for a mesh.
[[nodiscard]] std::optional<SurfacePoint> nearest_way_out(const Shape& shape,
                                                          const Vec3& inside) noexcept;
/// On a shape's curved face, met with that outward normal: the point of the same face that is
/// nearest to an inner point. Nothing on flat faces, and where the face ends before it.
[[nodiscard]] std::optional<SurfacePoint> nearest_on_curve(const Shape& shape, const Vec3& normal,
                                                           const Vec3& inside) noexcept;

/// No part of the shape is nearer to the point than this. Cheap, never too large.
[[nodiscard]] double at_least_away(const Shape& shape, const Vec3& point) noexcept;

} // namespace tactus::haptic

#pragma once

#include "core/haptic/scene/shape.hpp"

/// Boxes and disks offset by the radius of a spherical tool (m, > 0): the Minkowski sum of solid
/// and ball, whose surface is the set of positions of the tool's centre when it touches the solid.
/// For a convex solid these positions are the points at that radius from the solid, so that the
/// distance to the bare solid is enough. The sums for a sphere and a plane are a larger sphere and
/// a shifted plane (shape.cpp).
namespace tactus::haptic {

/// The point of the solid nearest to p; p itself inside.
[[nodiscard]] Vec3 nearest_point(const Box& box, const Vec3& p) noexcept;
[[nodiscard]] Vec3 nearest_point(const Disk& disk, const Vec3& p) noexcept;

/// For a rounded edge, corner or rim that is touched with this outward normal: the point of the
/// same rounding nearest to a point inside. Nothing on flat faces, or if the nearest point belongs
/// to another part of the surface.
[[nodiscard]] std::optional<SurfacePoint>
nearest_on_rounding(const Box& box, double radius, const Vec3& normal, const Vec3& inside) noexcept;
[[nodiscard]] std::optional<SurfacePoint> nearest_on_rounding(const Disk& disk, double radius,
                                                              const Vec3& normal,
                                                              const Vec3& inside) noexcept;

} // namespace tactus::haptic

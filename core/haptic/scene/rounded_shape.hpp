#pragma once

#include "core/haptic/scene/shape.hpp"

/// Solids and meshes as the centre of a spherical tool meets them: the Minkowski sum with a ball of
/// the tool's radius (m, > 0). A ball around a convex solid is that distance from it, so distance
/// to the bare solid is all that is needed. Spheres and planes need none of this: their sums are a
/// larger sphere and a shifted plane.
namespace tactus::haptic {

/// The point of the solid nearest to p; p itself inside.
[[nodiscard]] Vec3 nearest_point(const Box& box, const Vec3& p) noexcept;
[[nodiscard]] Vec3 nearest_point(const Disk& disk, const Vec3& p) noexcept;

/// On an edge, a corner or a rim touched with that outward normal: the position on the same one
/// nearest to an inner position. Nothing on flat faces, and where it ends before.
[[nodiscard]] std::optional<SurfacePoint>
nearest_on_rounding(const Box& box, double radius, const Vec3& normal, const Vec3& inside) noexcept;
[[nodiscard]] std::optional<SurfacePoint> nearest_on_rounding(const Disk& disk, double radius,
                                                              const Vec3& normal,
                                                              const Vec3& inside) noexcept;

} // namespace tactus::haptic

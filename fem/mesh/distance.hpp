#pragma once
#include "core/geometry/vec3.hpp"

namespace tactus::fem {

/// Distance of a point to a triangle, m.
[[nodiscard]] double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b,
                                          const Vec3& c);

/// Distance of the lines p q and a b if the nearest points lie within both edges. Otherwise, and
/// for parallel edges, returns 1e300, since then an end is nearest.
[[nodiscard]] double distance_of_edges(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b);

} // namespace tactus::fem

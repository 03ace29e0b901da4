#pragma once
#include "fem/mesh/vector3.hpp"

namespace tactus::fem {

/// Distance of a point to a triangle, m.
[[nodiscard]] double distance_to_triangle(const Vector3& p, const Vector3& a, const Vector3& b,
                                          const Vector3& c);

/// Distance of the lines p q and a b where it is reached within both; 1e300 elsewhere and for
/// parallel edges, where an end is nearest.
[[nodiscard]] double distance_of_edges(const Vector3& p, const Vector3& q, const Vector3& a,
                                       const Vector3& b);

} // namespace tactus::fem

#pragma once
#include "fem/io/triangles.hpp"

#include <functional>

namespace tactus::fem {

/// Reduces the number of triangles of a closed surface. Edges shorter than 0.8 `edge(position)` (m)
/// collapse onto one of their ends. The cheapest collapses come first, by the area-weighted squared
/// distance to the planes merged there (quadric error, Garland & Heckbert 1997). No edge becomes
/// longer than 4/3 `edge(position)`. Every old corner stays within `deviation` (m) of the new
/// surface, and no triangles cut each other that did not before; where a collapse would violate
/// this, the old triangles are kept. Shells keep their numbers. O(n log n).
[[nodiscard]] Triangles simplified(const Triangles&, const std::function<double(const Vec3&)>& edge,
                                   double deviation);

} // namespace tactus::fem

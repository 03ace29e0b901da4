#pragma once
#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::fem {

inline constexpr std::size_t kMaxEarCorners =
    4096; ///< limited, since the time of ear clipping grows with the square

/// Triangulates a polygon, plane or nearly so and possibly concave, by ear clipping in the plane of
/// its mean normal (Meisters 1975). Returns the corner numbers of the triangles, oriented like the
/// polygon.
[[nodiscard]] std::vector<std::array<int, 3>> clip_ears(std::span<const Vec3> corners);

} // namespace tactus::fem

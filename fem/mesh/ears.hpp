#pragma once
#include "fem/mesh/vector3.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::fem {

inline constexpr std::size_t kMaxEarCorners = 4096; ///< cutting ears takes their square

/// A polygon, plane or nearly so and possibly concave, as corner numbers of its triangles, turning
/// as the polygon does. Ears are cut in the plane of its mean normal (Meisters 1975).
[[nodiscard]] std::vector<std::array<int, 3>> clip_ears(std::span<const Vector3> corners);

} // namespace tactus::fem

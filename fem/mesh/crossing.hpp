#pragma once
#include "fem/io/triangles.hpp"

#include <optional>

namespace tactus::fem {

/// The boxes of all triangles.
[[nodiscard]] std::vector<Box> triangle_boxes(const Triangles&);

/// Up to `limit` pairs of triangles whose interiors cut each other, or neighbours that are folded
/// flat onto each other.
[[nodiscard]] std::vector<std::array<std::size_t, 2>> crossings(const Triangles&,
                                                                std::size_t limit);

/// The first pair of crossings(), or nullopt.
[[nodiscard]] std::optional<std::array<std::size_t, 2>> crossing(const Triangles&);

} // namespace tactus::fem

#pragma once
#include "fem/io/triangles.hpp"

#include <span>

namespace tactus::fem {

/// The polygons of a Wavefront OBJ file as triangles; each object (or, without objects, group) is a
/// group. Lines and points are passed over; free-form curves and surfaces are refused by name.
[[nodiscard]] Triangles read_obj(const std::string& path, const std::string& text, double unit);

/// A polygon, plane or nearly so and possibly concave, as corner numbers of its triangles, turning
/// as the polygon does. Ears are cut in the plane of its mean normal (Meisters 1975).
[[nodiscard]] std::vector<std::array<int, 3>> clip_ears(std::span<const Vector3> corners);

} // namespace tactus::fem

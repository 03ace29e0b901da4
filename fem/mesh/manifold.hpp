#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// Doubles points where more than two triangles meet at an edge, or several fans at a point, so
/// that each sheet is a surface of its own: neighbours at an edge are those with the body between
/// them. Refuses an edge with an odd number of triangles above one, with its position.
void make_manifold(Triangles&);

} // namespace tactus::fem

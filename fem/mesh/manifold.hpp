#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// Makes a surface manifold: at most two triangles at an edge and one fan of triangles around a
/// point. Where more meet, points are doubled, so that each sheet becomes a surface of its own; two
/// triangles that bound the same piece of the body stay neighbours. Refuses an edge with an odd
/// number of triangles above one, naming its position.
void make_manifold(Triangles&);

} // namespace tactus::fem

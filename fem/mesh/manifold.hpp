#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// Makes a surface manifold: at most two triangles share an edge, and one fan of triangles is
/// around a point. Where more triangles meet, points are duplicated, so that each sheet becomes a
/// separate surface. Two triangles that bound the same piece of the body stay neighbours. Refuses
/// an edge with an odd number of triangles above one, and names its position.
void make_manifold(Triangles&);

} // namespace tactus::fem

#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// The changes that weld() made to a surface.
struct Welded {
  double tolerance = 0;       ///< m, largest distance between merged corners
  std::size_t duplicates = 0; ///< triangles written twice, and walls between touching solids
  std::size_t split = 0;      ///< triangles split at a corner on their edge
  std::size_t fins = 0;       ///< triangles attached to the surface by only one edge
};

/// Makes one surface from unconnected triangles. Corners within the rounding of the file's numbers
/// are merged (four spacings of float32 at the largest coordinate). Corners on edges that are still
/// open are then merged at growing distances, up to 1e-4 of the body's size, if that closes edges
/// and no edge would vanish. An open edge with a corner on it (T-junction) is split there.
/// Triangles without area are removed, and so are duplicates. One of two copies stays if the
/// surface needs it, none if they are the wall between touching solids. If more than two triangles
/// meet at an edge, or several fans at a point, points are duplicated so that each piece becomes a
/// separate surface. At an edge, triangles with the body between them are neighbours. Refuses an
/// edge where that is impossible, and names its position.
Welded weld(Triangles&);

} // namespace tactus::fem

#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// What was done to a surface to weld it.
struct Welded {
  double tolerance = 0;       ///< m, the largest distance between corners that became one
  std::size_t duplicates = 0; ///< triangles written twice, and walls between touching solids
  std::size_t split = 0;      ///< triangles cut where a corner lay on their edge
  std::size_t fins = 0;       ///< triangles that hung on the surface by one edge
};

/// Makes one surface of a soup: corners within the rounding of the file's numbers become one point
/// (four spacings of float32 at the largest coordinate); corners on edges that are still open then
/// join at growing distances, up to 1e-4 of the body, where that closes edges and no edge would
/// vanish; an open edge with a corner on it is cut there (T-junction). Triangles without area go,
/// and so do duplicates: one of two stays where the surface needs it, none where the two are the
/// wall between touching solids. Where more than two triangles meet at an edge, or several fans at
/// a point, points are doubled so that each piece is a surface of its own: neighbours at an edge
/// are those with the body between them. Refuses edges where that is impossible, with their
/// position.
Welded weld(Triangles&);

} // namespace tactus::fem

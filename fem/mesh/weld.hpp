#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// The changes that weld() made to a surface.
struct Welded {
  double tolerance = 0;       ///< m, the largest distance between corners that became one
  std::size_t duplicates = 0; ///< triangles written twice, and walls between touching solids
  std::size_t split = 0;      ///< triangles cut where a corner lay on their edge
  std::size_t fins = 0;       ///< triangles that hung on the surface by one edge
};

/// Makes one surface from a soup of triangles. Corners within the rounding of the file's numbers
/// are merged (four spacings of float32 at the largest coordinate). Corners on edges that are still
/// open are then merged at growing distances, up to 1e-4 of the body's size, if that closes edges
/// and no edge would vanish; an open edge with a corner on it is split there (T-junction).
/// Triangles without area are removed, and so are duplicates: one of two stays if the surface needs
/// it, none if the two are the wall between touching solids. Where more than two triangles meet at
/// an edge, or several fans at a point, points are duplicated so that each piece becomes a separate
/// surface: neighbours at an edge are those with the body between them. Refuses edges where that is
/// impossible, with their position.
Welded weld(Triangles&);

} // namespace tactus::fem

#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// A hole of a surface: a ring of edges with a triangle on one side only.
struct Hole {
  Vec3 centre;       ///< m, mean of its corners
  double extent = 0; ///< m, largest side of its box
  double area = 0;   ///< m^2, area of the patch that closes it
  std::size_t edges = 0;
  bool closed = false;
  bool flat_opening = false; ///< closed although above the limits, since it is the only one and
                             ///< nearly plane
};

/// Closes holes whose patch is at most `area_share` of the surface and whose extent is at most
/// `extent_share` of the body's (both 0 to 1). Ear clipping of the ring makes the patch
/// (fem/mesh/ears.hpp). One larger hole, such as the missing bottom of a scan, is closed too if all
/// others are small, its corners lie within 2 % of its extent from a plane and the surface has 100
/// triangles or more. Call find_shells() before. Returns all holes, the largest first.
std::vector<Hole> close_holes(Triangles&, double area_share, double extent_share);

} // namespace tactus::fem

#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// A surface rebuilt from a grid, with measures of how well it approximates the old one.
struct Resurfaced {
  Triangles surface;
  double spacing = 0;       ///< m, of the grid
  double volume = 0;        ///< m^3, that the old surface encloses, counted once where it overlaps
  double inverted = 0;      ///< m^3, where it is inside out
  double volume_change = 0; ///< relative, of the new surface against `volume`
};

/// The outer skin of closed shells, outward or (cavities) inward, that may overlap, touch and
/// cross: the border of where their winding number is positive. Flat faces and sharp edges stay
/// within the grid's spacing. `finer` multiplies the number of grid points along a side.
[[nodiscard]] Resurfaced united(const Triangles& closed_shells, double finer = 1);

/// The skin that a ball of diameter `gap` (m) rolling over any triangles from outside leaves:
/// closed whatever the triangles are. Holes and crevices narrower than `gap` are closed, what lies
/// inside becomes solid; elsewhere it follows the triangles. Refuses triangles that enclose nothing
/// at that gap.
[[nodiscard]] Resurfaced shrink_wrapped(const Triangles&, double gap);

} // namespace tactus::fem

#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// Thrown if the ball of a wrap enters through a hole, so that only the sheet of triangles would
/// remain.
struct EnclosesNothing : InputError {
  using InputError::InputError;
};

/// A surface rebuilt from a grid, with measures of its deviation from the old surface.
struct Resurfaced {
  Triangles surface;
  double spacing = 0;       ///< spacing of the grid, m
  double volume = 0;        ///< volume within the old surface, overlaps counted once, m^3
  double inverted = 0;      ///< volume where the old surface is inverted, m^3
  double volume_change = 0; ///< relative difference of the new surface's volume from `volume`
};

/// The outer skin of closed shells that may overlap, touch and cross: the border of the region with
/// a positive winding number. Shells must be oriented outward, those of cavities inward. Flat faces
/// and sharp edges are kept to within the grid's spacing. `finer` multiplies the number of grid
/// points along a side.
[[nodiscard]] Resurfaced united(const Triangles& closed_shells, double finer = 1);

/// A closed skin around any triangles. It is the border of the region that a ball of diameter `gap`
/// (m) cannot reach when it rolls over the triangles from outside. Holes and crevices narrower than
/// `gap` are closed and their interior becomes solid; elsewhere the skin follows the triangles.
/// Refuses triangles that enclose nothing at that gap (EnclosesNothing).
[[nodiscard]] Resurfaced shrink_wrapped(const Triangles&, double gap);

} // namespace tactus::fem

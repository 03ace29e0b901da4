#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// A wrap whose ball enters through a hole: only the sheet of triangles would remain.
struct EnclosesNothing : InputError {
  using InputError::InputError;
};

/// A surface rebuilt from a grid, with measures of how well it approximates the old one.
struct Resurfaced {
  Triangles surface;
  double spacing = 0;       ///< m, of the grid
  double volume = 0;        ///< m^3, that the old surface encloses, counted once where it overlaps
  double inverted = 0;      ///< m^3, where it is inside out
  double volume_change = 0; ///< relative, of the new surface against `volume`
};

/// The outer skin of closed shells that may overlap, touch and cross: the border of the region with
/// a positive winding number. Shells are oriented outward, those of cavities inward. Flat faces and
/// sharp edges are kept to within the grid's spacing. `finer` multiplies the number of grid points
/// along a side.
[[nodiscard]] Resurfaced united(const Triangles& closed_shells, double finer = 1);

/// A closed skin around any triangles: the border of the region that a ball of diameter `gap` (m)
/// cannot reach when it rolls over them from outside. Holes and crevices narrower than `gap` are
/// closed and their interior becomes solid; elsewhere the skin follows the triangles. Refuses
/// triangles that enclose nothing at that gap (EnclosesNothing).
[[nodiscard]] Resurfaced shrink_wrapped(const Triangles&, double gap);

} // namespace tactus::fem

#pragma once
#include "fem/mesh/mesh_size.hpp"
#include "fem/shapes/shapes.hpp"

namespace tactus::fem {

/// A solid ball in hex20: a rounded cube in the middle and six blocks between its faces and the
/// sphere (a cubed sphere). The mesh has the ball's
/// volume: its nodes lie outside the sphere by a thousandth of an element.
///
///     .--------.      The grid's first direction cuts half a side of the cube, and its mirror
///     |\______/|      images all others; the second cuts the distance out to the sphere. There are
///     | |    | |      8 c^3 + 24 c^2 a elements, c and a the numbers of intervals.
///     | |____| |
///     |/      \|
///     '--------'
///
/// `h` is the size of elements, `at_least` the number of intervals in each direction; `grid` has
/// the lines to use instead. Sizes in m.
[[nodiscard]] SweptBody make_ball(double radius, double h, int at_least,
                                  const SweepGrid* grid = nullptr);
/// The size of the mesh of make_ball(): elements, nodes and node pairs are exact.
[[nodiscard]] MeshSize size_of_ball(double radius, double h, int at_least,
                                    const SweepGrid* grid = nullptr);

} // namespace tactus::fem

#pragma once
#include "fem/mesh/ray_grid.hpp"

namespace tactus::fem {

/// The closed surface, oriented outward, between the grid points that are inside and those that are
/// not. Each grid cell has one point for every sheet of surface in it (dual marching cubes, Nielson
/// 2004). The point lies at the intersection of the planes that the cell's edges meet (Ju et al.
/// 2002), so edges and corners of the body stay sharp. `inside` has one entry per grid point and is
/// false at the border. Grid edges from inside to outside without a crossing are cut in the middle.
/// Without `sharp` the points are the means of the cuts, for triangles with unreliable normals.
[[nodiscard]] Triangles dual_contour(const RayGrid&, const std::vector<std::uint8_t>& inside,
                                     bool sharp);

} // namespace tactus::fem

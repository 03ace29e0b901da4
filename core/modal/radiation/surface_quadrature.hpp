#pragma once

#include "core/geometry/surface.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::modal {

/// A point of a triangulated surface that stands for a piece of it.
struct SurfaceSource {
  std::uint32_t triangle = 0;
  std::array<float, 3> weight{}; ///< of the triangle's corners, sum 1
  double area_m2 = 0, distance_m = 0;
};

/// Points and areas for integrals over triangles of smooth functions times exp(-j k d)/d, d the
/// distance to the listener: rules of degree 1, 2 or 5 (Strang & Fix 1973; Radon 1948) by the
/// triangle's longest edge h against wavelength and distance, and quarters of triangles where
/// k h > 3 or h > d. A flat piston comes out within 0.01 dB up to that k.
///
/// `listener` in metres; `size` scales the surface; `wavenumber` k in 1/m, the highest that is to
/// be integrated; `nearest` m: no distance is taken for less.
[[nodiscard]] std::vector<SurfaceSource> surface_sources(const Surface& surface,
                                                         std::span<const std::size_t> triangles,
                                                         const Vec3& listener, double size,
                                                         double wavenumber, double nearest);

/// Corners of a triangulated surface as nodes: a vertex whose triangles turn by less than 30
/// degrees is one node with their mean normal; at an edge it is one node a side.
struct SurfaceNodes {
  std::vector<std::uint32_t> vertex;                        ///< [N]
  std::vector<Vec3> normal;                                 ///< [N] outwards, length 1
  std::vector<std::array<std::uint32_t, 3>> triangle_nodes; ///< [T]
};
[[nodiscard]] SurfaceNodes surface_nodes(const Surface& surface,
                                         std::span<const std::array<std::int32_t, 3>> triangles,
                                         std::size_t vertices);

} // namespace tactus::modal

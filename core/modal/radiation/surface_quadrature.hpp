#pragma once

#include "core/geometry/surface.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::modal {

/// A quadrature point on a triangulated surface, or the mean of an arc of equal distance.
struct SurfaceSource {
  std::uint32_t triangle = 0;
  std::array<float, 3> weight{}; ///< weights of the triangle's corners, sum 1
  double area_m2 = 0, distance_m = 0;
};

/// Limit of the number of quadrature points: a larger surface is resolved up to a lower wavenumber
/// than requested. The number grows with the size of a triangle, so that only bodies of many metres
/// with many triangles reach the limit.
inline constexpr std::size_t kMaxSurfaceSources = 2'000'000;

/// Quadrature points for integrals over triangles of smooth functions times exp(-j k d)/d, d the
/// distance to the listener.
///
/// The rule of a triangle has degree 1, 2 or 5 (Strang & Fix 1973; Radon 1948), by its longest edge
/// h compared with wavelength and distance. Where k h > 2 or h > d the triangle is divided into
/// arcs of equal distance, whose length and mean position are known exactly: d dd dphi is the
/// surface between two distances. The number of sources then grows with the triangle's length in
/// wavelengths, not with its area. The pressure of a flat piston is exact within 0.01 dB up to that
/// k.
///
/// `listener`: m. `size`: scales the surface. `wavenumber`: the largest k, 1/m. `nearest`: smaller
/// distances are set to this, m. Returns at most kMaxSurfaceSources points.
[[nodiscard]] std::vector<SurfaceSource> surface_sources(const Surface& surface,
                                                         std::span<const std::size_t> triangles,
                                                         const Vec3& listener, double size,
                                                         double wavenumber, double nearest);

/// The vertices of a triangulated surface with their normals. A vertex whose triangles' normals
/// differ by less than 30 degrees is one node with the mean normal; at a sharp edge it is one node
/// for each side.
struct SurfaceNodes {
  std::vector<std::uint32_t> vertex;                        ///< [N]
  std::vector<Vec3> normal;                                 ///< [N] outwards, length 1
  std::vector<std::array<std::uint32_t, 3>> triangle_nodes; ///< [T]
};
[[nodiscard]] SurfaceNodes surface_nodes(const Surface& surface,
                                         std::span<const std::array<std::int32_t, 3>> triangles,
                                         std::size_t vertices);

} // namespace tactus::modal

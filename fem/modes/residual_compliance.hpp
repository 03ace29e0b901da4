#pragma once
#include "fem/mesh/surface.hpp"
#include "fem/modes/modes.hpp"

namespace tactus::fem {

/// Default number of vertices at which the compliance is computed.
inline constexpr std::size_t kCompliancePoints = 128;

/// A unit force spread evenly over the skin within `radius` (m) of a vertex, each part inwards
/// along its own normal.
struct PushPatch {
  std::vector<std::size_t> node;
  std::vector<Vec3> force; ///< 1
  double area = 0;         ///< m^2
};
[[nodiscard]] PushPatch push_patch(const Mesh&, const Surface&, std::size_t vertex, double radius);

/// The static compliance at each vertex of the skin (m/N) that neither the computed modes nor a
/// contact law contains (residual flexibility):
///
///   r = f'(K^-1 - sum phi phi'/omega^2) f - 16 (1 - nu^2) / (3 pi^2 E R),    f = push_patch
///
/// K^-1 without the rigid motions; the last term is the mean depth of a half space under an even
/// pressure on a circle (Johnson 1985, 3.29), R that of the patch's area, because a Hertz contact
/// contains the half space's share already. Negative values are set to zero. K^-1 is taken from K +
/// s M, s far below the first mode left out, which it misses by s/omega^2. It is computed at
/// `probe_count` vertices that lie as far apart as possible, and interpolated from the nearest four
/// with weights 1/distance^2. The patch is some 1.5 elements wide: finer meshes resolve edges
/// better. Isotropic material of the first region.
[[nodiscard]] std::vector<float> residual_compliance(const Mesh&, std::span<const Material>,
                                                     const Matrices&, const Modes&,
                                                     std::size_t probe_count = kCompliancePoints,
                                                     const Progress& = {});

} // namespace tactus::fem

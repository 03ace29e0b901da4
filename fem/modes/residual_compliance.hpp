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
  std::vector<Vec3> force; ///< dimensionless
  double area = 0;         ///< m^2
};
[[nodiscard]] PushPatch push_patch(const Mesh&, const Surface&, std::size_t vertex, double radius);

/// The static compliance at each vertex of the skin (m/N) that neither the computed modes nor a
/// contact law contains (residual flexibility):
///
///   r = f'(K^-1 - sum phi phi'/omega^2) f - 16 (1 - nu^2) / (3 pi^2 E R),    f = push_patch
///
/// K^-1 excludes the rigid motions. The last term is the mean indentation of a half space under
/// uniform pressure on a circle (Johnson 1985, 3.29), with R the radius for the patch's area. It is
/// subtracted because a Hertz contact already contains the half space's compliance. Negative values
/// are set to zero. K^-1 is computed from K + s M, with s far below the first omitted mode, with a
/// relative error of s/omega^2. It is computed at `probe_count` vertices as far apart as possible,
/// and interpolated from the nearest four with weights 1/distance^2. The patch is about 1.5
/// elements wide, so finer meshes resolve edges better. Uses the isotropic material of the first
/// region.
[[nodiscard]] std::vector<float> residual_compliance(const Mesh&, std::span<const Material>,
                                                     const Matrices&, const Modes&,
                                                     std::size_t probe_count = kCompliancePoints,
                                                     const Progress& = {});

} // namespace tactus::fem

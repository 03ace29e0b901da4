#pragma once
#include "fem/assembly/matrices.hpp"

namespace tactus::fem {

/// Cauchy stress in Voigt order xx yy zz yz xz xy, Pa.
using Stress = std::array<double, 6>;

/// sqrt(((sx-sy)^2 + (sy-sz)^2 + (sz-sx)^2) / 2 + 3 (tyz^2 + txz^2 + txy^2)), Pa.
[[nodiscard]] double von_mises(const Stress&) noexcept;
/// Principal stresses, Pa, the largest first.
[[nodiscard]] std::array<double, 3> principal(const Stress&);
/// Tresca's largest shear (s1 - s3) / 2, Pa.
[[nodiscard]] double max_shear(const Stress&);

/// The derivative by each stress component, in Voigt order; shear counts once. It is zero where von
/// Mises is zero, and one-sided where principal stresses coincide.
[[nodiscard]] Stress von_mises_slope(const Stress&) noexcept;
[[nodiscard]] Stress max_shear_slope(const Stress&);

/// The stress C B u in an element at a reference point.
[[nodiscard]] Stress stress_at(const Mesh&, const Element&, const ElasticLaw&,
                               std::span<const double> displacement, const Vec3& reference);

/// Reference coordinates of an element's centre, the mean of its corners.
[[nodiscard]] Vec3 centroid_of(Shape) noexcept;
/// The shape functions at centroid_of().
[[nodiscard]] const ShapeValues& at_centroid(Shape);

/// The stress at each element's centroid, [element].
[[nodiscard]] std::vector<Stress> element_stress(const Mesh&, std::span<const Material>,
                                                 std::span<const double> displacement);

struct StressSample {
  Vec3 at; ///< m
  Stress stress;
};
/// The stress at each element's superconvergent points (4 in tet10, 2x2x2 in hex20, 3x2 in wedge15;
/// Barlow 1976), [element][point].
[[nodiscard]] std::vector<std::vector<StressSample>>
best_stress(const Mesh&, std::span<const Material>, std::span<const double> displacement);

/// The weights with which values at the superconvergent points are extrapolated to one of the
/// element's nodes.
[[nodiscard]] std::span<const double> shares_of_best_points(Shape, std::size_t node);

/// Volume of each element, m^3.
[[nodiscard]] std::vector<double> element_volumes(const Mesh&);

} // namespace tactus::fem

#pragma once

#include "core/design/shape_parameters.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace tactus::modal {

/// The derivatives of a body's eigenvalues with respect to its shape parameters, which give the
/// frequencies of other shapes.
///
/// The logarithm of omega^2 is extrapolated linearly from the shape d_0 of the table,
///   omega_k^2(d) = omega_k^2 exp(sum over p of slope_pk (d_p - d_p0) / omega_k^2).
/// This keeps omega^2 above 0, is exact for shapes scaled along an axis by exp(d) (omega^2 ~
/// scale^n), and has the least error of four expansions for stretched bars and plates
/// (docs/theory/modal_impact_shape.md). Mode shapes, mass and surface stay those of the table.
struct ShapeSensitivity {
  design::ShapeParameters shape;
  std::vector<double> eigenvalue_slope; ///< [P][K] d(omega^2)/dp, rad^2/s^2 per m
  std::vector<double> solved_at_m;      ///< [P] d_0, or empty: 0. Control points are those of d = 0

  [[nodiscard]] bool empty() const noexcept { return shape.parameters.empty(); }
  [[nodiscard]] std::size_t parameters() const noexcept { return shape.parameters.size(); }
  [[nodiscard]] double solved_at(std::size_t parameter) const noexcept {
    return solved_at_m.empty() ? 0 : solved_at_m[parameter];
  }
};

/// The largest factor of a frequency; the smallest is its inverse.
inline constexpr double kMaxShapeFactor = 4;
inline constexpr std::size_t kMaxShapeSlopes = 1U << 24; ///< parameters times modes: 128 MB

/// omega/omega_0 of each mode for parameters displaced by `displacement_m` (m, in the table's
/// size), limited to 1/kMaxShapeFactor..kMaxShapeFactor. Exactly 1 for the table's own shape, and
/// if the number of displacements is not that of the parameters. Allocates.
[[nodiscard]] std::vector<double> frequency_factors(const ShapeSensitivity& sensitivity,
                                                    std::span<const double> frequency_hz,
                                                    std::span<const double> displacement_m);

} // namespace tactus::modal

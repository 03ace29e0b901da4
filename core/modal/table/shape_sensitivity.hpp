#pragma once

#include "core/design/shape_parameters.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace tactus::modal {

/// How the frequencies of a body follow its shape, to first order.
///
/// omega^2 is extrapolated straight in its logarithm,
///   omega_k^2(d) = omega_k^2 exp(sum over p of slope_pk (d_p - d_p0) / omega_k^2),
///
/// from the shape d_0 that the table was solved at, which keeps it above 0, is exact for every body
/// whose shape is scaled along an axis by a factor exp(d) (omega^2 ~ scale^n) and errs least over
/// stretches and squeezes of bars and plates (docs/modal_impact.md, "Shape"). Mode shapes, mass and
/// surface stay those of the table.
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

/// A frequency is moved by this factor or its inverse at most.
inline constexpr double kMaxShapeFactor = 4;
inline constexpr std::size_t kMaxShapeSlopes = 1U << 24; ///< parameters times modes: 128 MB

/// omega/omega_0 of each mode when the parameters are displaced by so many metres (in the table's
/// size), within 1/kMaxShapeFactor..kMaxShapeFactor whatever the numbers. 1 for all, to the bit,
/// for those that the table was solved at and for a number of them that is not the parameters'.
/// Allocates.
[[nodiscard]] std::vector<double> frequency_factors(const ShapeSensitivity& sensitivity,
                                                    std::span<const double> frequency_hz,
                                                    std::span<const double> displacement_m);

} // namespace tactus::modal

#pragma once

#include "core/geometry/vec3.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace tactus::design {

/// One coordinate of one control point.
struct DesignParameter {
  std::size_t control_point = 0;
  int axis = 0;                 ///< 0 x, 1 y, 2 z
  double low_m = 0, high_m = 0; ///< bounds of its displacement; low <= 0 <= high
};

/// The shape parameters of a table that holds derivatives with respect to them.
struct ShapeParameters {
  std::vector<DesignParameter> parameters;
  std::vector<Vec3> control_point_m; ///< control points of the undeformed part
  double trust_m = 0; ///< largest displacement of a control point for which Taylor's error is small
};

inline constexpr std::size_t kMaxControlPoints = 4096; // the same limit as in the haptic protocol

/// Displaces a control point, each coordinate within its parameter's bounds; a coordinate without a
/// parameter stays. `displacement_m`: displacements of all parameters.
void displace(std::span<const DesignParameter> parameters, std::size_t control_point,
              const Vec3& by_m, std::span<double> displacement_m) noexcept;

/// The displacement of a control point; 0 along a coordinate that has no parameter.
[[nodiscard]] Vec3 displacement_of(std::span<const DesignParameter> parameters,
                                   std::size_t control_point,
                                   std::span<const double> displacement_m) noexcept;

/// Error sentence, such as "control point 9: expected 0..2", if no control point among `count` has
/// this number, or if it cannot move; else empty.
[[nodiscard]] std::string control_point_refusal(std::span<const DesignParameter> parameters,
                                                std::size_t count, double number);

} // namespace tactus::design

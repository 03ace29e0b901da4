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
  double low_m = 0, high_m = 0; ///< of its displacement; low <= 0 <= high
};

/// The shape parameters of a table that holds derivatives with respect to them.
struct ShapeParameters {
  std::vector<DesignParameter> parameters;
  std::vector<Vec3> control_point_m; ///< of the undeformed part
  double trust_m = 0; ///< largest displacement of a control point for which Taylor's error is small
};

inline constexpr std::size_t kMaxControlPoints = 4096; // as the haptic protocol's

/// Displaces a control point, each coordinate within its parameter's bounds; one that has no
/// parameter stays. `displacement_m` are those of all parameters.
void displace(std::span<const DesignParameter> parameters, std::size_t control_point,
              const Vec3& by_m, std::span<double> displacement_m) noexcept;

/// The displacement of a control point; 0 along a coordinate that has no parameter.
[[nodiscard]] Vec3 displacement_of(std::span<const DesignParameter> parameters,
                                   std::size_t control_point,
                                   std::span<const double> displacement_m) noexcept;

/// "control point 9: expected 0..2" when there is none of this number among `count`, or none that
/// can move; else empty.
[[nodiscard]] std::string control_point_refusal(std::span<const DesignParameter> parameters,
                                                std::size_t count, double number);

} // namespace tactus::design

#pragma once
#include "core/geometry/vec3.hpp"

#include <array>

namespace tactus::fem {

/// A flat triangle with three hat functions, and the values that integrals over it need.
struct Panel {
  std::array<Vec3, 3> corner;
  Vec3 normal, middle;
  double area = 0, radius = 0; ///< radius is the distance from the middle to the farthest corner
  std::array<Vec3, 3> curl;    ///< (signed) surface curl of each hat function, 1/m
  std::array<Vec3, 3> point;   ///< points of the three-point rule, each of weight area/3

  explicit Panel(const std::array<Vec3, 3>& corners);
};

/// Values of the three hat functions (second index) at the three points of the rule.
inline constexpr std::array<std::array<double, 3>, 3> kHatAtPoint{
    {{2. / 3, 1. / 6, 1. / 6}, {1. / 6, 2. / 3, 1. / 6}, {1. / 6, 1. / 6, 2. / 3}}};

/// Closed forms over a panel for a point x, after Wilton et al. 1984 and Graglia 1993: ∫ phi_a / R
/// dS and ∫ phi_a h / R^3 dS, where h is the height of x over the panel.
struct StaticIntegrals {
  std::array<double, 3> potential{}, slope{};
};
[[nodiscard]] StaticIntegrals static_integrals(const Panel&, const Vec3& x);

} // namespace tactus::fem

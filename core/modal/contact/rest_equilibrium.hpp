#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::modal {

/// How a rigid body lies on points that only push: gains g of a force at each point on the body's
/// six rigid motions, 1/sqrt(kg) (unit inertia), and a constant load on these, N/sqrt(kg).
///
/// Motions that no point resists (sliding, turning about the line through two points) are held
/// without loss, by friction or a cord's guides: `basis` is an orthonormal basis of the others, the
/// span of the gains.
struct RestEquilibrium {
  using Rigid = std::array<double, 6>;
  /// Contact forces F >= 0 with sum of (F - pressing) g = -load within the span, N: what the points
  /// carry beyond what presses the bodies together at each of them. Where many such forces exist,
  /// those of points equally stiff (least sum of squares); points that would pull are lifted off.
  std::vector<double> force_n;
  std::vector<Rigid> basis;
  bool balanced = true; ///< false: there are no such forces, the body tips over

  RestEquilibrium(std::span<const Rigid> gain, const Rigid& load, double pressing_n);
};

} // namespace tactus::modal

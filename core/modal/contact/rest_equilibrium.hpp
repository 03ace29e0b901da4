#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::modal {

/// The static contact forces of a rigid body that rests on points which can push but not pull.
///
/// A force at point i acts on the body's six rigid motions (of unit inertia) by the gains g_i,
/// 1/sqrt(kg). A constant load acts on the same motions, N/sqrt(kg). Motions that no point resists
/// (sliding, turning about the line through two points) are assumed fixed without loss, as friction
/// or the guides of a cord fix them. Only the span of the gains is solved.
struct RestEquilibrium {
  using Rigid = std::array<double, 6>;
  /// Contact forces F_i >= 0, N, with sum of (F_i - pressing) g_i = -load within the span. If there
  /// are many solutions, it is the one with the least sum of squares (equally stiff points). Points
  /// that would pull are lifted off.
  std::vector<double> force_n;
  std::vector<Rigid> basis; ///< orthonormal, of the span of the gains
  bool balanced = true;     ///< false: no such forces exist, the body tips over

  /// Allocates. `pressing_n`: the force that presses the bodies together at each point, besides the
  /// load.
  RestEquilibrium(std::span<const Rigid> gain, const Rigid& load, double pressing_n);
};

} // namespace tactus::modal

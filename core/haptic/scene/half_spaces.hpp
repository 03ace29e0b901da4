#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace tactus::haptic {

/// The points x with normal . x >= offset; the normal is of unit length.
struct HalfSpace {
  Vec3 normal;
  double offset;
};

inline constexpr std::size_t kMaxHalfSpaces = 4;

/// Result of nearest_point().
struct NearestPoint {
  Vec3 point;
  /// Lagrange multipliers, m: point = goal + sum multiplier_i normal_i, all >= 0.
  std::array<double, kMaxHalfSpaces> multiplier{};
};

/// The point of the intersection of at most four half spaces that is nearest to the goal:
///   min |x - goal|^2   subject to   normal_i . x >= offset_i,
/// solved by testing the Karush-Kuhn-Tucker conditions for every set of up to three active faces.
/// Returns nothing if rounding hides the solution, for example between nearly parallel faces.
[[nodiscard]] std::optional<NearestPoint> nearest_point(std::span<const HalfSpace> faces,
                                                        const Vec3& goal) noexcept;

} // namespace tactus::haptic

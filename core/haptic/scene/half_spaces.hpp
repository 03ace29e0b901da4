#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace tactus::haptic {

/// All x with normal . x >= offset; the normal is of unit length.
struct HalfSpace {
  Vec3 normal;
  double offset;
};

inline constexpr std::size_t kMaxHalfSpaces = 4;

struct NearestPoint {
  Vec3 point;
  /// How far each half space pushes: point = goal + sum push_i normal_i, none negative.
  std::array<double, kMaxHalfSpaces> multiplier{};
};

/// The point common to at most four half spaces that is nearest to the goal: the optimum of
/// min |x - goal|^2, found by trying every set of up to three active faces for the conditions of
/// Karush, Kuhn and Tucker. Nothing when rounding hides it, as when faces are nearly parallel.
[[nodiscard]] std::optional<NearestPoint> nearest_point(std::span<const HalfSpace> faces,
                                                        const Vec3& goal) noexcept;

} // namespace tactus::haptic

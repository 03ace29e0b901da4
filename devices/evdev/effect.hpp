#pragma once

#include "core/geometry/vec3.hpp"

#include <cstdint>

namespace tactus::devices::evdev {

/// A constant force as the kernel's interface says it.
struct ConstantForce {
  std::int16_t level = 0;      ///< 0..32767
  std::uint16_t direction = 0; ///< 65536 a turn: 0 pulls to the user, then left, away, right
  friend bool operator==(const ConstantForce&, const ConstantForce&) = default;
};

/// The share of peak_n that lies in the plane of the stick, x right and z towards the user; without
/// a second axis the x part alone. What is not finite is none.
[[nodiscard]] ConstantForce constant_force(const haptic::Vec3& force_n, double peak_n,
                                           bool two_axes) noexcept;

} // namespace tactus::devices::evdev

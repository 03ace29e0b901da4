#pragma once

#include "core/geometry/vec3.hpp"

#include <cstdint>

namespace tactus::devices::evdev {

/// A constant force in the units of the kernel's force-feedback interface (linux/input.h).
struct ConstantForce {
  std::int16_t level = 0;      ///< -32767..32767
  std::uint16_t direction = 0; ///< 65536 a turn: 0 pulls to the user, then left, away, right
  friend bool operator==(const ConstantForce&, const ConstantForce&) = default;
};

/// The force's part in the plane of the stick (x right, z towards the user) as a share of peak_n,
/// N. Without a second axis x only, by the level's sign: drivers of wheels ignore the direction or
/// put 0x4000 in its place (drivers/hid/usbhid/hid-pidff.c, PIDFF_FIXED_WHEEL_DIRECTION), so it is
/// always that, left, and a positive level pulls to the left. A force that is not finite gives
/// none.
[[nodiscard]] ConstantForce constant_force(const Vec3& force_n, double peak_n,
                                           bool two_axes) noexcept;

} // namespace tactus::devices::evdev

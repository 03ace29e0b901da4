#pragma once

#include "core/geometry/vec3.hpp"

#include <cstdint>

namespace tactus::devices::evdev {

/// A constant force in the units of the kernel's force-feedback interface (linux/input.h).
struct ConstantForce {
  std::int16_t level = 0;      ///< -32767..32767
  std::uint16_t direction = 0; ///< 65536 per turn; 0 pulls towards the user, 0x4000 left
  friend bool operator==(const ConstantForce&, const ConstantForce&) = default;
};

/// The component of the force in the plane of the stick (x right, z towards the user), relative to
/// peak_n, N. Without a second axis only x counts, and its sign is in the level, because drivers of
/// wheels ignore the direction or replace it by 0x4000 (drivers/hid/usbhid/hid-pidff.c,
/// PIDFF_FIXED_WHEEL_DIRECTION). The direction is then always 0x4000, left, and a positive level
/// pulls to the left. A force that is not finite counts as zero.
[[nodiscard]] ConstantForce constant_force(const Vec3& force_n, double peak_n,
                                           bool two_axes) noexcept;

} // namespace tactus::devices::evdev

#pragma once

#include "core/haptic/scene/pose.hpp"

#include <cmath>

namespace tactus::devices::haply {

/// The service's transform from the device to the application's space: p_application = t + R (s p),
/// s a factor per axis. Project frame. The mount (the position of the device, set by a preset) and
/// the workspace transform (navigation in a scene, which another program may set) both have this
/// form.
struct Transform {
  haptic::Pose pose{}; ///< t, m, and R
  Vec3 scale{1, 1, 1}; ///< s

  /// False for a scale or a quaternion that cannot be undone.
  [[nodiscard]] bool valid() const noexcept {
    constexpr double kMin = 1e-3, kMax = 1e3, kUnit = 1e-2;
    for (const double s : {scale.x, scale.y, scale.z})
      if (!(std::abs(s) >= kMin && std::abs(s) <= kMax))
        return false;
    const haptic::Rotation& q = pose.rotation;
    return is_finite(pose.position) &&
           std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < kUnit;
  }
  /// R v.
  [[nodiscard]] Vec3 rotated(const Vec3& v) const noexcept { return pose.rotation.rotated(v); }
  /// Converts a position from the application's space to the device's, where it is the handle's in
  /// m.
  [[nodiscard]] Vec3 point(const Vec3& p) const noexcept { return unscaled(pose.to_local(p)); }
  /// Converts a velocity from the application's space to the device's.
  [[nodiscard]] Vec3 motion(const Vec3& v) const noexcept {
    return unscaled(pose.rotation.inverse().rotated(v));
  }

private:
  [[nodiscard]] Vec3 unscaled(const Vec3& v) const noexcept {
    return {v.x / scale.x, v.y / scale.y, v.z / scale.z};
  }
};

} // namespace tactus::devices::haply

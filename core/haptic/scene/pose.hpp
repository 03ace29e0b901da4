#pragma once

#include "core/geometry/vec3.hpp"

namespace tactus::haptic {

/// a - (a . u) u with u = along/|along|: the part of a perpendicular to `along`.
inline Vec3 without_component(const Vec3& a, const Vec3& along) noexcept {
  const double length = norm(along);
  if (!(length > 0.0))
    return a;
  const Vec3 unit = along * (1.0 / length);
  return a - unit * dot(a, unit);
}

/// A rotation in space as a unit quaternion w + x i + y j + z k.
struct Rotation {
  double w = 1, x = 0, y = 0, z = 0;

  /// v + 2 w (q x v) + 2 q x (q x v), q = (x, y, z).
  [[nodiscard]] Vec3 rotated(const Vec3& v) const noexcept {
    const Vec3 q{x, y, z}, first = 2.0 * cross(q, v);
    return v + w * first + cross(q, first);
  }
  [[nodiscard]] Rotation inverse() const noexcept { return {w, -x, -y, -z}; }
  /// The quaternion (w, x, y, z) scaled to unit length; the identity if this is not possible.
  [[nodiscard]] static Rotation of(double w, double x, double y, double z) noexcept;
  /// The smallest rotation that takes the z axis to this direction; the identity if the direction
  /// is zero or not finite.
  [[nodiscard]] static Rotation from_z_to(const Vec3& direction) noexcept;
  friend bool operator==(const Rotation&, const Rotation&) = default;
};

/// Position and orientation of a body's frame in the project frame.
struct Pose {
  Vec3 position{}; ///< m
  Rotation rotation{};

  [[nodiscard]] Vec3 to_world(const Vec3& local) const noexcept {
    return position + rotation.rotated(local);
  }
  [[nodiscard]] Vec3 to_local(const Vec3& world) const noexcept {
    return rotation.inverse().rotated(world - position);
  }
  friend bool operator==(const Pose&, const Pose&) = default;
};

} // namespace tactus::haptic

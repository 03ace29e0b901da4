#include "core/haptic/scene/pose.hpp"

namespace tactus::haptic {

Rotation Rotation::of(double w, double x, double y, double z) noexcept {
  const double largest = std::max({std::abs(w), std::abs(x), std::abs(y), std::abs(z)});
  if (!(largest > 0.0) || !std::isfinite(w + x + y + z))
    return {};
  const double a = w / largest, b = x / largest, c = y / largest, d = z / largest;
  const double length = std::sqrt(a * a + b * b + c * c + d * d);
  return {a / length, b / length, c / length, d / length};
}

Rotation Rotation::from_z_to(const Vec3& direction) noexcept {
  const double length = norm(direction);
  if (!(length > 0.0) || !std::isfinite(length))
    return {};
  const Vec3 n = direction * (1.0 / length);
  if (n.z < -1.0 + 1e-12)
    return {0, 1, 0, 0};
  // Half way between the axes: the quaternion (1 + z.n, z x n), scaled to unit length.
  return of(1.0 + n.z, -n.y, n.x, 0.0);
}

} // namespace tactus::haptic

#include "core/haptic/device/workspace.hpp"

namespace tactus::haptic {

Vec3 Workspace::normalised(const Vec3& position) const noexcept {
  Vec3 result;
  for (int axis = 0; axis < 3; ++axis) {
    const double width = max[axis] - min[axis];
    const double fraction = (position[axis] - min[axis]) / width;
    result[axis] = width > 0.0 && !std::isnan(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.5;
  }
  return result;
}

void Workspace::include(const Vec3& position) noexcept {
  if (!is_finite(position))
    return;
  for (int axis = 0; axis < 3; ++axis) {
    min[axis] = std::min(min[axis], position[axis]);
    max[axis] = std::max(max[axis], position[axis]);
  }
}

bool Workspace::valid() const noexcept {
  return is_finite(min) && is_finite(max) && min.x <= max.x && min.y <= max.y && min.z <= max.z;
}

Vec3 AxisMap::to_project(const Vec3& device) const noexcept {
  return {sign[0] * device[source[0]], sign[1] * device[source[1]], sign[2] * device[source[2]]};
}

Vec3 AxisMap::to_device(const Vec3& project) const noexcept {
  Vec3 device;
  for (std::size_t axis = 0; axis < 3; ++axis)
    device[source[axis]] = sign[axis] * project[static_cast<int>(axis)];
  return device;
}

double AxisMap::determinant() const noexcept {
  const bool even = (source[1] - source[0] + 3) % 3 == 1; // xyz, yzx, zxy
  return (even ? 1.0 : -1.0) * sign[0] * sign[1] * sign[2];
}

Vec3 AxisMap::torque_to_device(const Vec3& project) const noexcept {
  return to_device(project) * determinant();
}

Vec3 AxisMap::rotation_to_project(const Vec3& device) const noexcept {
  return to_project(device) * determinant();
}

std::optional<AxisMap> AxisMap::parse(std::string_view axes,
                                      const std::array<double, 3>& signs) noexcept {
  if (axes.size() != 3)
    return std::nullopt;
  AxisMap map;
  int seen = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int source = axes[axis] - 'x';
    if (source < 0 || source > 2 || std::abs(signs[axis]) != 1.0)
      return std::nullopt;
    map.source[axis] = source;
    map.sign[axis] = signs[axis];
    seen |= 1 << source;
  }
  return seen == 7 ? std::optional(map) : std::nullopt;
}

} // namespace tactus::haptic

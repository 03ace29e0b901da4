#pragma once

#include "core/haptic/device/device.hpp"

#include <array>
#include <optional>
#include <string_view>

namespace tactus::haptic {

/// The box of positions, m, that the outlets map to 0..1.
struct Workspace {
  Vec3 min{-0.05, -0.05, -0.05}, max{0.05, 0.05, 0.05};

  /// clamp((p - min) / (max - min), 0, 1) on each axis; 0.5 on an axis without width.
  [[nodiscard]] Vec3 normalised(const Vec3& position) const noexcept;
  /// Grows the box to contain the position.
  void include(const Vec3& position) noexcept;
  /// Finite and min <= max on each axis.
  [[nodiscard]] bool valid() const noexcept;
  friend bool operator==(const Workspace&, const Workspace&) = default;
};

/// Maps the device's axes to the project frame: project axis i is sign[i] times device axis
/// source[i]. This signed permutation is orthogonal; forces go back by its transpose, so that the
/// power F . v is the same in both frames.
struct AxisMap {
  std::array<int, 3> source{0, 1, 2};
  std::array<double, 3> sign{1, 1, 1};

  [[nodiscard]] Vec3 to_project(const Vec3& device) const noexcept;
  [[nodiscard]] Vec3 to_device(const Vec3& project) const noexcept;
  /// Torque and rotation are axial vectors: they also change sign when the map is a reflection.
  [[nodiscard]] Vec3 torque_to_device(const Vec3& project) const noexcept;
  [[nodiscard]] Vec3 rotation_to_project(const Vec3& device) const noexcept;
  [[nodiscard]] double determinant() const noexcept; ///< 1, or -1 for a reflection
  /// From "zxy" and three signs (+1 or -1); nothing when the word is not a permutation of xyz.
  [[nodiscard]] static std::optional<AxisMap> parse(std::string_view axes,
                                                    const std::array<double, 3>& signs) noexcept;
};

} // namespace tactus::haptic

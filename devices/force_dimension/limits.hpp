#pragma once

#include "core/haptic/device/device.hpp"

#include <string_view>

namespace tactus::devices::force_dimension {

/// The limits of a device model: peak force, stable stiffness and damping, radius of the workspace.
struct Model {
  int type; ///< the value of dhdGetSystemType
  std::string_view name;
  double peak_force_n, stiffness_n_per_m, damping_n_s_per_m, radius_m;
  double peak_torque_n_m = 0, peak_grip_n = 0; ///< 0 if the model has no such motors
};

/// The limits that CHAI3D has for the type. Newer libraries report types that CHAI3D does not list:
/// they get the limits of the model that the library names, or else the smallest of all.
[[nodiscard]] const Model& model_of(int type, std::string_view name = {}) noexcept;
[[nodiscard]] haptic::Caps caps_of(const Model& model) noexcept;

} // namespace tactus::devices::force_dimension

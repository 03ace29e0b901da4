#pragma once

#include "core/geometry/vec3.hpp"
#include "devices/hid/knob.hpp"

#include <string>
#include <string_view>

namespace tactus::devices::hid {

/// Maps the axes of a HID to three of position and three of rotation.
struct AxisTable {
  struct Source {
    int axis = -1; ///< index into Knob::share, -1: none
    double sign = 1;
  };
  std::array<Source, 6> rows{};

  /// HID's axes are X right, Y towards the user, Z down, so the project's x, y, z are X, -Z, Y. A
  /// device without Z uses its slider for the height. early: the device's axes point right, up and
  /// away from the user (is_early_space_mouse).
  [[nodiscard]] static AxisTable default_for(std::uint32_t axes, bool early = false) noexcept;
  /// Reads rows "x -Z", "rz Ry", "y none", # comments; axes without a row keep their mapping.
  /// Returns an empty text, or a sentence if the text is refused; the table is then unchanged.
  [[nodiscard]] std::string read(std::string_view text);

  [[nodiscard]] Vec3 position(const Knob& knob) const noexcept;
  [[nodiscard]] Vec3 rotation(const Knob& knob) const noexcept;
};

/// Returns 0 within the dead zone; beyond it the result rises linearly to 1 at full deflection.
[[nodiscard]] double apply_dead_zone(double share, double dead_zone) noexcept;

} // namespace tactus::devices::hid

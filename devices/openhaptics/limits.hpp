#pragma once

#include "core/haptic/device/device.hpp"
#include "devices/openhaptics/hd_library.hpp"

#include <string_view>

namespace tactus::devices::openhaptics {

/// Limits of a model by CHAI3D's table, for a library that does not report them. An unknown model
/// gets the smallest force of the table. model: the text that hdGetString(model type) returns.
[[nodiscard]] haptic::Caps table_caps(std::string_view model) noexcept;

/// As table_caps(), but with the values that the open device reports, where they are plausible.
[[nodiscard]] haptic::Caps device_caps(const HdLibrary& library, std::string_view model) noexcept;

} // namespace tactus::devices::openhaptics

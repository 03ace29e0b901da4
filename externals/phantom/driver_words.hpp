#pragma once

#include "core/haptic/device/device.hpp"
#include "core/object.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace tactus::phantom {

/// "evdev, falcon or net"; the list may begin with "sim", the simulated device.
[[nodiscard]] std::string driver_names(bool with_simulation);
/// Passes words to a device's driver as a setting; with `which` as the choice of a device. Returns
/// a sentence when they are refused.
[[nodiscard]] std::string configure(haptic::Backend& device, std::span<const Atom> words,
                                    bool which);
/// Words after a driver's name are a setting, as after `driver`, or say which device.
[[nodiscard]] std::string configure_new(haptic::Backend& device, std::span<const Atom> words);
/// Sends what a driver says of a device; `-` where it says nothing.
void send_device(std::string_view driver, std::size_t index, const haptic::Identity& identity,
                 std::string_view state, Host& host);

} // namespace tactus::phantom

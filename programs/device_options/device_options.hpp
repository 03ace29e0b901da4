#pragma once

#include "core/haptic/device/device.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::programs {

/// Which device a program opens, and how it is set.
struct DeviceOptions {
  std::string driver, which;                        ///< --device DRIVER[:WHICH]
  std::vector<std::vector<std::string>> settings{}; ///< --set "WORD VALUE...", once each
};

/// Takes --device and --set. Nothing when the option is another one; false when its value is not
/// understood.
[[nodiscard]] std::optional<bool> set_device_option(std::string_view name, const std::string& value,
                                                    DeviceOptions& options);

/// Gives the device its settings, then its WHICH. Empty, or the device's first refusal.
[[nodiscard]] std::string configure(haptic::Backend& device, const DeviceOptions& options);

/// A number from min to max and nothing behind it.
[[nodiscard]] std::optional<double> number_of(std::string_view text, double min, double max);

/// What the usage text says of an option, on one line: "0..65535; 0 takes one that is free (7770)".
/// Empty when it has no line that begins with two spaces and the option.
[[nodiscard]] std::string option_text(std::string_view usage, std::string_view name);

/// The error for a wrong value of an option, or for an option that there is not.
[[nodiscard]] std::string option_refusal(std::string_view usage, const std::string& name,
                                         std::string_view value);

} // namespace tactus::programs

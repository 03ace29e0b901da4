#pragma once

#include "core/haptic/device/device.hpp"
#include "programs/haptic_check/stations.hpp"

#include <string>
#include <vector>

namespace tactus::haptic_check {

/// Lines of text: for each driver its summary, followed by the missing parts or by the devices that
/// it lists.
[[nodiscard]] std::vector<std::string> inventory();

/// A driver and one of its devices that is ready; empty if there is none.
struct Choice {
  std::string driver, which;
};
[[nodiscard]] Choice first_ready();

/// The device's own description.
struct DeviceDescription {
  haptic::Identity identity;
  haptic::Caps caps;
};

/// The text to paste into an issue. Names no serial number.
[[nodiscard]] std::string report(const Options& options, const DeviceDescription& device,
                                 double force_limit_n, const std::vector<Finding>& findings,
                                 const std::string& error, const std::vector<std::string>& drivers);

} // namespace tactus::haptic_check

#pragma once

#include "core/haptic/device/device.hpp"
#include "devices/hid/hid_library.hpp"
#include "devices/hid/report_descriptor.hpp"

#include <optional>
#include <vector>

namespace tactus::devices::hid {

/// A HID device that the driver can use.
struct Entry {
  std::string path;
  haptic::Identity identity;
  std::uint16_t vendor = 0, product = 0;
  bool space_mouse = false; ///< a six-axis controller, by its usage or known id
  std::string problem;      ///< empty if the device can be opened
};

/// The product ids of six-axis controllers, for a transport that does not report the usage.
[[nodiscard]] bool is_known_space_mouse(std::uint16_t vendor, std::uint16_t product) noexcept;

/// True for an early six-axis controller, whose axes point right, up and away from the user. The
/// axes of all others point right, towards the user and down. The early controllers are those of
/// spacenavd's table (src/dev.c, usbdb) without the flags DF_SWAPYZ and DF_INVYZ.
[[nodiscard]] bool is_early_space_mouse(std::uint16_t vendor, std::uint16_t product) noexcept;

/// Six-axis controllers first, then joysticks and game pads. With `all`, every HID.
[[nodiscard]] std::vector<Entry> catalogue(HidLibrary& library, bool all = false);

/// The device's own report descriptor; empty if this transport does not provide it.
[[nodiscard]] std::optional<ReportDescriptor> describe(HidLibrary& library, hid_device* device,
                                                       const std::string& path);

} // namespace tactus::devices::hid

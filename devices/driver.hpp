#pragma once

#include "core/haptic/device/device.hpp"

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Real haptic devices behind core/haptic's interface, one folder a driver. A driver never stands
/// in another's way: libraries are loaded when they are needed (devices/shared_library.hpp), and
/// one that is missing costs that driver alone.
namespace tactus::devices {

/// A device that a driver sees now.
struct Found {
  std::string_view driver;
  int index = 0; ///< what `open INDEX` takes
  haptic::Identity identity;
  std::string state; ///< "ready", or what keeps it from being opened ("no permission", ...)
};

/// One kind of device.
struct Driver {
  std::string_view name;    ///< as in `backend NAME`
  std::string_view summary; ///< which devices, in a few words
  /// Empty when the driver can work on this machine; else what is missing and what to install.
  std::string (*problem)();
  /// May take some hundred milliseconds; for a thread that may wait.
  std::vector<Found> (*list)();
  std::unique_ptr<haptic::Backend> (*make)();
};

/// All that tactus knows and was added, those included that this build or this machine has no
/// library for.
[[nodiscard]] std::span<const Driver* const> drivers() noexcept;
/// A driver of another room, which the program or external that knows both joins to them; once, and
/// false when there is one of that name or no room.
bool add_driver(const Driver& driver) noexcept;
/// Null when there is no such driver.
[[nodiscard]] const Driver* find_driver(std::string_view name) noexcept;

} // namespace tactus::devices

#pragma once

#include "core/haptic/device/device.hpp"

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Drivers of real haptic devices, one folder each; every one implements haptic::Backend. Vendors'
/// libraries are loaded when they are first needed (devices/shared_library.hpp). A missing library
/// disables its own driver only.
namespace tactus::devices {

/// A device that a driver has found.
struct Found {
  std::string_view driver;
  int index = 0; ///< INDEX of the message `open INDEX`
  haptic::Identity identity;
  std::string state; ///< "ready", or why it cannot be opened ("no permission", ...)
};

/// One kind of device.
struct Driver {
  std::string_view name;    ///< NAME of the message `backend NAME`
  std::string_view summary; ///< short description of the devices
  /// Empty when the driver can work on this machine; else what is missing and what to install.
  std::string (*problem)();
  /// May take some hundred milliseconds, so the calling thread must be allowed to wait.
  std::vector<Found> (*list)();
  std::unique_ptr<haptic::Backend> (*make)();
};

/// All drivers of this build and those that add_driver() added. A driver whose library is missing
/// is listed, too; its problem() says so.
[[nodiscard]] std::span<const Driver* const> drivers() noexcept;
/// Adds a driver that lives outside devices/, such as net's. False when the name is taken or the
/// list is full (4 added drivers).
bool add_driver(const Driver& driver) noexcept;
/// Null when there is no such driver.
[[nodiscard]] const Driver* find_driver(std::string_view name) noexcept;

} // namespace tactus::devices

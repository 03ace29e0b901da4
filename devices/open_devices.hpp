#pragma once

#include "devices/driver.hpp"

namespace tactus::devices {

/// Registers a device as open in this process while the object lives. Listing devices then uses the
/// registered identity and does not query a device that is running.
class OpenDevice {
public:
  OpenDevice() = default;
  ~OpenDevice() { clear(); }
  OpenDevice(const OpenDevice&) = delete;
  OpenDevice& operator=(const OpenDevice&) = delete;

  /// index: the INDEX of `open INDEX`. address: where the device is plugged in, for a driver that
  /// finds its devices on a bus; else the library's handle of the device.
  void set(std::string_view driver, int index, haptic::Identity identity, std::string address = {});
  void clear() noexcept;

private:
  bool set_ = false;
};

struct Opened {
  Found found; ///< its state is "open"
  std::string address;
};

/// The open devices of one driver, in the order of opening. Takes a lock: not for the servo's
/// thread.
[[nodiscard]] std::vector<Opened> open_devices(std::string_view driver);
/// Whether the device with that address is open now.
[[nodiscard]] bool is_open(std::string_view driver, std::string_view address);

} // namespace tactus::devices

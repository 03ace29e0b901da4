#pragma once

#include "devices/driver.hpp"

namespace tactus::devices {

/// A device that this process has open. Drivers say it here, so that a list beside it answers from
/// what is known and asks neither the device nor its library.
class OpenDevice {
public:
  OpenDevice() = default;
  ~OpenDevice() { clear(); }
  OpenDevice(const OpenDevice&) = delete;
  OpenDevice& operator=(const OpenDevice&) = delete;

  /// index: what `open INDEX` took. address: where the device is plugged in, for a driver that
  /// finds its devices on a bus; else the library's handle of it.
  void set(std::string_view driver, int index, haptic::Identity identity, std::string address = {});
  void clear() noexcept;

private:
  bool set_ = false;
};

struct Opened {
  Found found; ///< its state says that it is open
  std::string address;
};

/// Those of one driver that are open now, in the order of their opening; for any thread that may
/// wait.
[[nodiscard]] std::vector<Opened> open_devices(std::string_view driver);
/// Whether the device with that address is open now.
[[nodiscard]] bool is_open(std::string_view driver, std::string_view address);

} // namespace tactus::devices

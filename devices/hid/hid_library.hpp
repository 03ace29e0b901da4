#pragma once

#include "devices/shared_library.hpp"

#include <mutex>
#include <string>

#include <hidapi.h>

namespace tactus::devices::hid {

/// The build of hidapi to use.
enum class Transport { kAny, kHidraw, kLibusb };

/// The functions of hidapi that the driver calls. hidapi has two builds: hidraw goes through the
/// kernel's HID driver and knows each device's description, libusb takes the device away from it.
struct HidLibrary {
  decltype(&::hid_init) init = nullptr;
  decltype(&::hid_enumerate) enumerate = nullptr;
  decltype(&::hid_free_enumeration) free_enumeration = nullptr;
  decltype(&::hid_open_path) open_path = nullptr;
  decltype(&::hid_close) close = nullptr;
  decltype(&::hid_read_timeout) read_timeout = nullptr;
  decltype(&::hid_write) write = nullptr;
  /// Since hidapi 0.14, else null.
  int (*get_report_descriptor)(hid_device*, unsigned char*, std::size_t) = nullptr;
  bool hidraw = false;

  /// The library of that transport, kAny: hidraw if it is there. It stays loaded, since
  /// unloading would end every open device. Null, with a sentence in `problem`, on failure.
  [[nodiscard]] static HidLibrary* get(Transport transport, std::string& problem);

private:
  std::string load(Transport transport);

  SharedLibrary library_;
  bool ready_ = false;
};

} // namespace tactus::devices::hid

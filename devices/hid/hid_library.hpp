#pragma once

#include "devices/shared_library.hpp"

#include <mutex>
#include <string>

#include <hidapi.h>

namespace tactus::devices::hid {

/// The build of hidapi to use.
enum class Transport { kAny, kHidraw, kLibusb };

/// The functions of hidapi that the driver calls. hidapi has two builds: hidraw uses the kernel's
/// HID driver and provides each device's report descriptor; libusb detaches the device from the
/// kernel.
class HidLibrary {
  SharedLibrary library_;
  static constexpr auto kOptional = LibraryFunction::Needed::kNo;

public:
  Function<decltype(hid_init)> init{library_, "hid_init"};
  Function<decltype(hid_enumerate)> enumerate{library_, "hid_enumerate"};
  Function<decltype(hid_free_enumeration)> free_enumeration{library_, "hid_free_enumeration"};
  Function<decltype(hid_open_path)> open_path{library_, "hid_open_path"};
  Function<decltype(hid_close)> close{library_, "hid_close"};
  Function<decltype(hid_read_timeout)> read_timeout{library_, "hid_read_timeout"};
  Function<decltype(hid_write)> write{library_, "hid_write"};
  /// Null before hidapi 0.14.
  Function<int(hid_device*, unsigned char*, std::size_t)> get_report_descriptor{
      library_, "hid_get_report_descriptor", kOptional};
  bool hidraw = false;

  /// The library of that transport; kAny prefers hidraw if it is installed. The library stays
  /// loaded, since unloading would end every open device. On failure returns null and puts a
  /// sentence into `problem`.
  [[nodiscard]] static HidLibrary* get(Transport transport, std::string& problem);

private:
  std::string load(Transport transport);

  bool ready_ = false;
};

} // namespace tactus::devices::hid

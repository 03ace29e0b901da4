#include "devices/falcon/usb_library.hpp"

#include <array>

namespace tactus::devices::falcon {

std::string UsbLibrary::load() {
  constexpr std::array<const char*, 6> kNames{"libusb-1.0.so.0",
                                              "libusb-1.0.so",
                                              "libusb-1.0.dylib",
                                              "/opt/homebrew/lib/libusb-1.0.dylib",
                                              "/usr/local/lib/libusb-1.0.dylib",
                                              "libusb-1.0.dll"};
  if (!library_.load(kNames))
    return "libusb 1.0 cannot be loaded (" + library_.error() +
           "): install Debian's libusb-1.0-0, or libusb from libusb.info";
  if (const char* missing = library_.missing())
    return library_.name() + " has no " + missing + ": install libusb 1.0.16 or newer";
  return {};
}

} // namespace tactus::devices::falcon

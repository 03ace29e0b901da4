#include "devices/hid/hid_library.hpp"

#include <array>

namespace tactus::devices::hid {

std::string HidLibrary::load(Transport transport) {
  if (ready_)
    return {};
#if defined(__linux__)
  constexpr std::array<const char*, 2> kHidrawNames{"libhidapi-hidraw.so.0", "libhidapi-hidraw.so"};
  constexpr std::array<const char*, 2> kLibusbNames{"libhidapi-libusb.so.0", "libhidapi-libusb.so"};
  hidraw = transport == Transport::kHidraw;
  const bool loaded = library_.load(hidraw ? kHidrawNames : kLibusbNames);
#else
  static_cast<void>(transport);
  constexpr std::array<const char*, 4> kNames{"libhidapi.dylib",
                                              "/opt/homebrew/lib/libhidapi.dylib",
                                              "/usr/local/lib/libhidapi.dylib", "hidapi.dll"};
  const bool loaded = library_.load(kNames);
#endif
  if (!loaded)
    return "hidapi cannot be loaded (" + library_.error() +
           "): install Debian's libhidapi-hidraw0, or hidapi from github.com/libusb/hidapi";
  if (const char* missing = library_.missing())
    return library_.name() + " has no " + missing + ": install hidapi 0.8 or newer";
  if (init() != 0)
    return library_.name() + " cannot start: check that /dev exists";
  ready_ = true;
  return {};
}

HidLibrary* HidLibrary::get(Transport transport, std::string& problem) {
  static std::mutex mutex;
  // Never destroyed: a thread may still be reading when the program ends.
  static HidLibrary& hidraw_library = *new HidLibrary;
  static HidLibrary& libusb_library = *new HidLibrary;
  const std::scoped_lock lock(mutex);
  if (transport != Transport::kLibusb) {
    problem = hidraw_library.load(Transport::kHidraw);
    if (problem.empty())
      return &hidraw_library;
  }
  if (transport != Transport::kHidraw) {
    const std::string reason = libusb_library.load(Transport::kLibusb);
    if (reason.empty()) {
      problem.clear();
      return &libusb_library;
    }
    if (problem.empty())
      problem = reason;
  }
  return nullptr;
}

} // namespace tactus::devices::hid

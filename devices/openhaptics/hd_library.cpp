#include "devices/openhaptics/hd_library.hpp"

#include <cstdlib>
#include <vector>

namespace tactus::devices::openhaptics {
namespace {

std::vector<const char*> file_names() {
  if (const char* wanted = std::getenv("PHANTOM_LIBHD"); wanted && *wanted)
    return {wanted};
#ifdef _WIN32
  return {"HD.dll"};
#else
  return {"libHD.so.3.4", "libHD.so", "libHD.so.3"};
#endif
}

/// A device that does not answer ranks above warm motors.
int severity(Code code) noexcept {
  switch (code) {
  case kSuccess:
    return 0;
  case kTooMuchForce:
    return 1;
  case kWarmMotors:
    return 2;
  case kNoAnswer:
  case kDeviceFault:
    return 4;
  default:
    return 3;
  }
}

} // namespace

std::string HdLibrary::load() {
  const std::vector<const char*> names = file_names();
  if (!library_.load(names)) {
    if (library_.found()) {
      const bool needs_driver = library_.error().find("PhantomIO") != std::string::npos;
      return "the OpenHaptics library cannot be loaded: " + library_.error() +
             (needs_driver ? "; that file comes with 3D Systems' Touch device driver: install it"
                           : "; install 3D Systems' Touch device driver and OpenHaptics for this "
                             "machine, or set PHANTOM_LIBHD to the path of libHD");
    }
    return "the OpenHaptics library was not found (tried " + SharedLibrary::joined(names) + ": " +
           library_.error() +
           "): install 3D Systems' Touch device driver and OpenHaptics from "
           "support.3dsystems.com, or set PHANTOM_LIBHD to the path of libHD";
  }
  if (const char* missing = library_.missing()) {
    return library_.name() + " has no function " + missing +
           ": install OpenHaptics 3.4 or newer, or set "
           "PHANTOM_LIBHD to the path of its libHD";
  }
  return {};
}

Code HdLibrary::take_errors(bool* warm) const noexcept {
  constexpr int kMaxErrors = 32;
  Code worst = kSuccess;
  for (int i = 0; i < kMaxErrors; ++i) {
    const Code code = get_error().code;
    if (code == kSuccess)
      break;
    if (warm && code == kWarmMotors)
      *warm = true;
    if (severity(code) > severity(worst))
      worst = code;
  }
  return worst;
}

} // namespace tactus::devices::openhaptics

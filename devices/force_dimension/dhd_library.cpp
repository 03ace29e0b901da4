#include "devices/force_dimension/dhd_library.hpp"

#include <cstdlib>
#include <vector>

namespace tactus::devices::force_dimension {
namespace {

std::vector<const char*> file_names() {
  if (const char* wanted = std::getenv("TACTUS_LIBDHD"); wanted && *wanted)
    return {wanted};
#ifdef _WIN32
  return {"drd64.dll", "dhd64.dll"};
#elif defined(__APPLE__)
  return {"libdrd.dylib", "libdhd.dylib"};
#else
  return {"libdrd.so.3", "libdrd.so", "libdhd.so.3", "libdhd.so"}; // libdrd contains libdhd
#endif
}

} // namespace

std::string DhdLibrary::load() {
  const std::vector<const char*> names = file_names();
  if (!library_.load(names)) {
    return "Force Dimension's library " +
           (library_.found() ? std::string("cannot be loaded (")
                             : "was not found (tried " + SharedLibrary::joined(names) + ": ") +
           library_.error() +
           "): get the SDK from www.forcedimension.com/software/sdk and put its libdhd where the "
           "system finds libraries, or set TACTUS_LIBDHD to its path";
  }
  if (const char* missing = library_.missing()) {
    return library_.name() + " has no function " + missing +
           ": install version 3 of Force Dimension's SDK, or "
           "set TACTUS_LIBDHD to the path of its libdhd";
  }
  if (robot_open_id && robot_close) {
    open_id = robot_open_id; // opens like dhdOpenID, but DRD can then move the device
    close = robot_close;
  }
  return {};
}

} // namespace tactus::devices::force_dimension

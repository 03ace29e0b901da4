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
  return {"libdrd.so.3", "libdrd.so", "libdhd.so.3", "libdhd.so"}; // libdrd holds libdhd too
#endif
}

} // namespace

std::string DhdLibrary::load() {
  const std::vector<const char*> names = file_names();
  if (!library_.load(names)) {
    return "Force Dimension's library " +
           (library_.found() ? std::string("does not load (")
                             : "is not here (tried " + SharedLibrary::joined(names) + ": ") +
           library_.error() +
           "); get the SDK from www.forcedimension.com/software/sdk and put its libdhd where the "
           "system finds libraries, or set TACTUS_LIBDHD to its path";
  }
  RequiredSymbols need(library_);
  need("dhdGetDeviceCount", device_count);
  need("dhdOpenID", open_id);
  need("dhdClose", close);
  need("dhdGetSystemType", system_type);
  need("dhdGetPosition", position);
  need("dhdGetLinearVelocity", linear_velocity);
  need("dhdSetForce", set_force);
  need("dhdEnableForce", enable_force);
  need("dhdErrorGetLastStr", last_error);
  if (const char* missing = need.missing()) {
    return library_.name() + " has no function " + missing +
           "; it is not version 3 of Force Dimension's SDK: install that, or "
           "set TACTUS_LIBDHD to the path of its libdhd";
  }
  library_.symbol("dhdOpenSerial", open_serial);
  library_.symbol("dhdGetSystemName", system_name);
  library_.symbol("dhdGetSerialNumber", serial_number);
  library_.symbol("dhdGetButtonMask", button_mask);
  library_.symbol("dhdGetStatus", status);
  library_.symbol("dhdGetOrientationRad", orientation);
  library_.symbol("dhdHasWrist", has_wrist);
  library_.symbol("dhdHasActiveWrist", has_active_wrist);
  library_.symbol("dhdHasGripper", has_gripper);
  library_.symbol("dhdHasActiveGripper", has_active_gripper);
  library_.symbol("dhdGetGripperGap", gripper_gap);
  library_.symbol("dhdSetForceAndTorqueAndGripperForce", set_all);
  library_.symbol("dhdReset", reset);
  library_.symbol("dhdEnableExpertMode", expert_mode);
  library_.symbol("dhdDisableExpertMode", ordinary_mode);
  library_.symbol("dhdSetWatchdog", set_watchdog);
  library_.symbol("dhdSetMaxForce", set_max_force);
  decltype(open_id) robot_open_id = nullptr;
  decltype(close) robot_close = nullptr;
  if (library_.symbol("drdOpenID", robot_open_id) && library_.symbol("drdClose", robot_close)) {
    open_id = robot_open_id; // as dhdOpenID, and the device can be led
    close = robot_close;
    library_.symbol("drdIsSupported", robot_supported);
    library_.symbol("drdAutoInit", auto_init);
    library_.symbol("drdStop", robot_stop);
  }
  return {};
}

} // namespace tactus::devices::force_dimension

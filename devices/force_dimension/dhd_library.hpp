#pragma once

#include "devices/shared_library.hpp"

#include <string>

namespace tactus::devices::force_dimension {

/// Return values of the vendor's functions: negative values are errors; the following values are
/// not.
constexpr int kTimeGuard = 1;      ///< called too soon: repeats the last answer
constexpr int kMotorSaturated = 2; ///< the force was applied, but smaller than requested

/// Indices into the array that dhdGetStatus fills; newer libraries fill more of them.
enum Status : std::size_t {
  kPowered = 0,
  kConnected = 1,
  kNeedsReset = 3,
  kForceOn = 5,
  kBroken = 9,
  kForceOffCause = 14
};
constexpr std::size_t kMaxStatus = 64;

enum ForceOffCause : int {
  kNoCause = 0,
  kForceButton = 1,
  kTooFast = 2,
  kWatchdog = 3,
  kSoftware = 4,
  kUnplugged = 5,
  kDeadMan = 6
};

/// The vendor's library, loaded at run time (DHD, the haptic part of its SDK, and DRD, the robotic
/// part, which moves the handle by position control). The functions are declared as public programs
/// use them.
class DhdLibrary {
  SharedLibrary library_;
  static constexpr auto kOptional = LibraryFunction::Needed::kNo;

public:
  Function<int()> device_count{library_, "dhdGetDeviceCount"};
  Function<int(char index)> open_id{library_, "dhdOpenID"};
  Function<int(char id)> close{library_, "dhdClose"};
  Function<int(char id)> system_type{library_, "dhdGetSystemType"};
  Function<int(double* x, double* y, double* z, char id)> position{library_, "dhdGetPosition"}; // m
  Function<int(double* x, double* y, double* z, char id)> linear_velocity{
      library_, "dhdGetLinearVelocity"};                                                   // m/s
  Function<int(double x, double y, double z, char id)> set_force{library_, "dhdSetForce"}; // N
  Function<int(unsigned char on, char id)> enable_force{library_, "dhdEnableForce"};
  Function<const char*()> last_error{library_, "dhdErrorGetLastStr"};
  // May be null in some versions:
  Function<int(int serial)> open_serial{library_, "dhdOpenSerial", kOptional};
  Function<const char*(char id)> system_name{library_, "dhdGetSystemName", kOptional};
  Function<int(unsigned short* serial, char id)> serial_number{library_, "dhdGetSerialNumber",
                                                               kOptional};
  Function<unsigned int(char id)> button_mask{library_, "dhdGetButtonMask", kOptional};
  Function<int(int* all, char id)> status{library_, "dhdGetStatus", kOptional};
  Function<int(double* a, double* b, double* c, char id)> orientation{
      library_, "dhdGetOrientationRad", kOptional}; // rad
  Function<bool(char id)> has_wrist{library_, "dhdHasWrist", kOptional};
  Function<bool(char id)> has_active_wrist{library_, "dhdHasActiveWrist", kOptional};
  Function<bool(char id)> has_gripper{library_, "dhdHasGripper", kOptional};
  Function<bool(char id)> has_active_gripper{library_, "dhdHasActiveGripper", kOptional};
  Function<int(double* opening, char id)> gripper_gap{library_, "dhdGetGripperGap", kOptional}; // m
  Function<int(double fx, double fy, double fz, double tx, double ty, double tz, double grip,
               char id)>
      set_all{library_, "dhdSetForceAndTorqueAndGripperForce", kOptional}; // N, N m, N
  Function<int(char id)> reset{library_, "dhdReset", kOptional};
  Function<int()> expert_mode{library_, "dhdEnableExpertMode", kOptional};
  Function<int()> ordinary_mode{library_, "dhdDisableExpertMode", kOptional};
  Function<int(unsigned char steps, char id)> set_watchdog{library_, "dhdSetWatchdog",
                                                           kOptional}; // in steps of 125 us
  Function<int(double newton, char id)> set_max_force{library_, "dhdSetMaxForce", kOptional};
  // Only in libdrd:
  Function<int(char index)> robot_open_id{library_, "drdOpenID", kOptional};
  Function<int(char id)> robot_close{library_, "drdClose", kOptional};
  Function<bool(char id)> robot_supported{library_, "drdIsSupported", kOptional};
  Function<int(char id)> auto_init{library_, "drdAutoInit", kOptional};
  Function<int(bool motors_on, char id)> robot_stop{library_, "drdStop", kOptional};

  /// Returns an empty text if every required function was found; else a sentence about what is
  /// missing and what to do. The environment variable TACTUS_LIBDHD names the file; without it the
  /// usual names are tried.
  [[nodiscard]] std::string load();
};

} // namespace tactus::devices::force_dimension

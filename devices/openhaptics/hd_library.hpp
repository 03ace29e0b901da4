#pragma once

#include "devices/shared_library.hpp"

#include <string>

namespace tactus::devices::openhaptics {

/// The part of the vendor's C interface (HDAPI) that the driver uses, as public programs declare
/// it.
using Handle = unsigned int;
using Code = unsigned int;
using SchedulerHandle = unsigned long;
using Callback = unsigned int (*)(void* context);

struct ErrorInfo {
  Code code = 0;
  int internal_code = 0;
  Handle device = 0;
};

constexpr Handle kNoDevice = 0xFFFFFFFFu;
constexpr Code kSuccess = 0;
constexpr unsigned int kCallbackDone = 0, kCallbackContinue = 1;
constexpr unsigned short kHighestPriority = 65535;

/// Abilities that are switched on and off.
enum Ability : Code {
  kForceOutput = 0x4000,
  kMaxForceClamping = 0x4001,
  kForceRamping = 0x4002,
};

/// Values that can be read; some can also be set.
enum Value : Code {
  kButtons = 0x2000,
  kPosition = 0x2050,     ///< mm
  kVelocity = 0x2051,     ///< mm/s
  kGimbalAngles = 0x2150, ///< rad
  kModelType = 0x2501,
  kVendor = 0x2503,
  kSerialNumber = 0x2504,
  kMaxWorkspace = 0x2550,    ///< 6 values: smallest x y z, largest x y z, mm
  kUsableWorkspace = 0x2551, ///< likewise, for the box in which the force is reliable
  kOutputAxes = 0x2554,      ///< number of motors: 3, or 6 with torque
  kCalibrationStyle = 0x2555,
  kNominalMaxStiffness = 0x2602,       ///< N/mm
  kNominalMaxForce = 0x2603,           ///< N
  kNominalMaxContinuousForce = 0x2604, ///< N
  kNominalMaxDamping = 0x2609,         ///< N s/mm
  kNominalMaxTorque = 0x2622,          ///< mN m
  kForce = 0x2700,                     ///< N
  kTorque = 0x2701,                    ///< mN m, Cartesian
};

enum Error : Code {
  kWarmMotors = 0x0200,
  kTooMuchForce = 0x0201,
  kTooMuchImpulse = 0x0202,
  kTooMuchVelocity = 0x0203,
  kForceError = 0x0204,
  kDeviceFault = 0x0300,
  kAlreadyOpen = 0x0301,
  kNoAnswer = 0x0302,
  kWrongPort = 0x0303,
  kTimerError = 0x0304,
  kFrameError = 0x0402,
  kNoLicence = 0x0600,
};

enum Calibration : Code {
  kCalibrated = 0x5000,
  kCalibrationNeedsUpdate = 0x5001,
  kCalibrationNeedsHand = 0x5002,
};

/// Bits of kCalibrationStyle; hdUpdateCalibration takes one of them (OpenHaptics API Reference,
/// "Calibration Routines").
enum CalibrationStyle : Code {
  kResetEncoders = 1, ///< the arm must be in its reset position at that moment
  kAutomatic = 2,
  kInkwell = 4,
};

/// The vendor's library, loaded while the program runs.
class HdLibrary {
  SharedLibrary library_;
  static constexpr auto kOptional = LibraryFunction::Needed::kNo;

public:
  Function<Handle(const char* name)> init_device{library_, "hdInitDevice"};
  Function<void(Handle device)> disable_device{library_, "hdDisableDevice"};
  Function<void(Handle device)> make_current_device{library_, "hdMakeCurrentDevice"};
  Function<void(Code ability)> enable{library_, "hdEnable"};
  Function<void(Code ability)> disable{library_, "hdDisable"};
  Function<void(Handle device)> begin_frame{library_, "hdBeginFrame"};
  Function<void(Handle device)> end_frame{library_, "hdEndFrame"};
  Function<void(Code value, double* answer)> get_doubles{library_, "hdGetDoublev"};
  Function<void(Code value, int* answer)> get_integers{library_, "hdGetIntegerv"};
  Function<void(Code value, const double* wanted)> set_doubles{library_, "hdSetDoublev"};
  Function<const char*(Code value)> get_string{library_, "hdGetString"};
  Function<ErrorInfo()> get_error{library_, "hdGetError"};
  Function<SchedulerHandle(Callback callback, void* context, unsigned short priority)> schedule{
      library_, "hdScheduleAsynchronous"};
  Function<void(SchedulerHandle handle)> unschedule{library_, "hdUnschedule"};
  Function<void()> start_scheduler{library_, "hdStartScheduler"};
  Function<void()> stop_scheduler{library_, "hdStopScheduler"};
  Function<Code()> check_calibration{library_, "hdCheckCalibration"};
  Function<void(Code style)> update_calibration{library_, "hdUpdateCalibration",
                                                kOptional}; ///< may be null
  Function<void(unsigned long hz)> set_scheduler_rate{library_, "hdSetSchedulerRate",
                                                      kOptional}; ///< may be null

  /// Returns an empty text if every function was found; else a sentence about what is missing and
  /// what to do. The environment variable PHANTOM_LIBHD names the file; without it the usual names
  /// are tried.
  [[nodiscard]] std::string load();

  /// Removes all stored errors, oldest first, and returns the most serious one. Sets *warm, if
  /// given, to true if warm motors were among them.
  [[nodiscard]] Code take_errors(bool* warm = nullptr) const noexcept;
};

} // namespace tactus::devices::openhaptics

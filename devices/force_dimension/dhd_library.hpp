#pragma once

#include "devices/shared_library.hpp"

#include <string>

namespace tactus::devices::force_dimension {

/// Answers of the vendor's functions: below zero is an error; these are none.
constexpr int kTimeGuard = 1;      ///< the answer is the last one again: too soon for a new one
constexpr int kMotorSaturated = 2; ///< force was given, but less than asked for

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

/// The vendor's library (DHD, the haptic part of its SDK, and DRD, the robotic part, which leads
/// the handle by itself), loaded while the program runs; the
/// functions are declared as public programs use them.
struct DhdLibrary {
  int (*device_count)() = nullptr;
  int (*open_id)(char index) = nullptr;
  int (*close)(char id) = nullptr;
  int (*system_type)(char id) = nullptr;
  int (*position)(double* x, double* y, double* z, char id) = nullptr;        // m
  int (*linear_velocity)(double* x, double* y, double* z, char id) = nullptr; // m/s
  int (*set_force)(double x, double y, double z, char id) = nullptr;          // N
  int (*enable_force)(unsigned char on, char id) = nullptr;
  const char* (*last_error)() = nullptr;
  // May be null in some versions:
  int (*open_serial)(int serial) = nullptr;
  const char* (*system_name)(char id) = nullptr;
  int (*serial_number)(unsigned short* serial, char id) = nullptr;
  unsigned int (*button_mask)(char id) = nullptr;
  int (*status)(int* all, char id) = nullptr;
  int (*orientation)(double* a, double* b, double* c, char id) = nullptr; // rad
  bool (*has_wrist)(char id) = nullptr;
  bool (*has_active_wrist)(char id) = nullptr;
  bool (*has_gripper)(char id) = nullptr;
  bool (*has_active_gripper)(char id) = nullptr;
  int (*gripper_gap)(double* opening, char id) = nullptr; // m
  int (*set_all)(double fx, double fy, double fz, double tx, double ty, double tz, double grip,
                 char id) = nullptr; // N, N m, N
  int (*reset)(char id) = nullptr;
  int (*expert_mode)() = nullptr;
  int (*ordinary_mode)() = nullptr;
  int (*set_watchdog)(unsigned char steps, char id) = nullptr; // of 125 us
  int (*set_max_force)(double newton, char id) = nullptr;
  // Of libdrd alone:
  bool (*robot_supported)(char id) = nullptr;
  int (*auto_init)(char id) = nullptr;
  int (*robot_stop)(bool motors_on, char id) = nullptr;

  /// Empty when every function that must be there is; else what is missing and what to do. The
  /// environment's TACTUS_LIBDHD names the file; else the usual names are tried.
  [[nodiscard]] std::string load();

private:
  SharedLibrary library_;
};

} // namespace tactus::devices::force_dimension

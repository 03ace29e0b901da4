#pragma once

#include "core/haptic/device/motor_control.hpp"

namespace tactus::phantom {

/// Motors that the handler of SIGTERM stops. In the host's thread, only the handler then runs; the
/// servos' threads continue.
class TerminationGuard {
public:
  explicit TerminationGuard(haptic::MotorControl& motors) noexcept;
  ~TerminationGuard();
  TerminationGuard(const TerminationGuard&) = delete;
  TerminationGuard& operator=(const TerminationGuard&) = delete;

  /// driven: a thread steps the servo of these motors, so that the handler waits until that servo
  /// has written zero force. Installs the handler, unless the host has its own.
  void set_driven(bool driven) noexcept;

private:
  int slot_ = -1;
};

} // namespace tactus::phantom

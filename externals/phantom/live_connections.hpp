#pragma once

#include "core/haptic/device/motor_control.hpp"

namespace tactus::phantom {

/// Base of objects that may hold a real device. Where the host's program ends without deleting its
/// objects, let_go() is called for each of them before the process ends.
class LiveConnection {
public:
  /// Starts to bring the force to zero and to close the device, in other threads. Does not wait.
  virtual void let_go() noexcept = 0;

protected:
  LiveConnection();
  ~LiveConnection();
  LiveConnection(const LiveConnection&) = delete;
  LiveConnection& operator=(const LiveConnection&) = delete;
};

/// Motors that the handler of SIGTERM stops. In the host's thread only the handler still runs then;
/// the servos' threads run on.
class TerminationGuard {
public:
  explicit TerminationGuard(haptic::MotorControl& motors) noexcept;
  ~TerminationGuard();
  TerminationGuard(const TerminationGuard&) = delete;
  TerminationGuard& operator=(const TerminationGuard&) = delete;

  /// driven: a thread steps the servo of these motors, so that the handler waits for its zero
  /// force. Installs the handler, unless the host has one of its own.
  void set_driven(bool driven) noexcept;

private:
  int slot_ = -1;
};

} // namespace tactus::phantom

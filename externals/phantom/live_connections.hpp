#pragma once

#include "core/haptic/device/motor_control.hpp"

namespace tactus::phantom {

/// Whoever holds a real device. A host may end without deleting its objects; what is registered is
/// let go then, before the process is gone.
class LiveConnection {
public:
  /// Begins the end: force to zero, device closed, by threads that go on. Does not wait.
  virtual void let_go() noexcept = 0;

protected:
  LiveConnection();
  ~LiveConnection();
  LiveConnection(const LiveConnection&) = delete;
  LiveConnection& operator=(const LiveConnection&) = delete;
};

/// Motors that the handler of SIGTERM stops. The process is then being terminated and no code but
/// the handler runs any more in the host's thread, while the servos' threads still do.
class TerminationGuard {
public:
  explicit TerminationGuard(haptic::MotorControl& motors) noexcept;
  ~TerminationGuard();
  TerminationGuard(const TerminationGuard&) = delete;
  TerminationGuard& operator=(const TerminationGuard&) = delete;

  /// From now on a SIGTERM that the host leaves alone stops the force first. `driven`: somebody
  /// steps the servo of these motors, so that the handler waits for its zero force.
  void set_driven(bool driven) noexcept;

private:
  int slot_ = -1;
};

} // namespace tactus::phantom

#pragma once

namespace tactus::phantom {

/// Whoever holds a real device. A host may end without deleting its objects; what is registered is
/// let go then, before the process is gone.
class LiveConnection {
public:
  /// Force to zero, device closed, no thread left.
  virtual void let_go() noexcept = 0;
  /// The process is being terminated and no code but a signal's handler runs any more in the host's
  /// thread: tells the servo, whose thread still runs, to write no force.
  virtual void stop_now() noexcept = 0;
  /// Whether it has.
  [[nodiscard]] virtual bool stopped() noexcept = 0;
  /// From now on a SIGTERM that the host leaves alone stops the force first.
  static void guard_termination() noexcept;

protected:
  LiveConnection();
  ~LiveConnection();
  LiveConnection(const LiveConnection&) = delete;
  LiveConnection& operator=(const LiveConnection&) = delete;
};

} // namespace tactus::phantom

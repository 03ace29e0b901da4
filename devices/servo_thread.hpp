#pragma once

#include "core/haptic/servo/servo.hpp"

#include <memory>
#include <string>
#include <string_view>
#include <thread>

namespace tactus::devices {

/// Steps a servo on the machine's monotonic clock: in a thread of its own, or in the thread of a
/// device's own driver. One thread uses this object at a time.
///
/// A call of a driver may hang. What the servo's steps touch must then live as long as the thread
/// that hangs in them: `owner` keeps it alive, and stop() does not wait longer than it is told to.
class ServoThread {
public:
  ServoThread() = default;
  /// With an owner, a thread that does not end within stop()'s time is left to itself.
  ~ServoThread();
  ServoThread(const ServoThread&) = delete;
  ServoThread& operator=(const ServoThread&) = delete;

  /// Empty when it runs, else one sentence. Without an owner, servo and device must outlive this.
  [[nodiscard]] std::string start(haptic::Servo& servo, double period_s,
                                  std::shared_ptr<void> owner = {});
  /// As that device wants it.
  [[nodiscard]] std::string start(haptic::Servo& servo, haptic::Backend& device, double period_s,
                                  std::shared_ptr<void> owner = {});
  /// Asks for the end and waits for it, `timeout_s` at most, or as long as it takes without an
  /// owner. True when nobody touches the servo any more; false: not yet, and it may be asked again.
  /// The servo's own thread writes zero force before it ends.
  [[nodiscard]] bool stop(double timeout_s = 0.5) noexcept;
  [[nodiscard]] bool running() const noexcept { return run_ != nullptr; }
  /// Of the servo's own thread, from its next tick on.
  void set_period(double period_s) noexcept;
  /// Whether the device took the zero force at the end of the last run; true before any.
  [[nodiscard]] bool released() const noexcept { return released_; }
  /// How the thread is scheduled: "fifo", "nice", "other", or "driver" when it is the driver's;
  /// empty before it is known.
  [[nodiscard]] std::string_view scheduling() const noexcept;

  /// The clock that the thread runs on.
  [[nodiscard]] static double now_s() noexcept;

private:
  struct Run;
  static void run(Run& run) noexcept;
  static void step_from_driver(void* run) noexcept;
  void halt_driver() noexcept;

  std::shared_ptr<Run> run_; // shared with whoever steps
  std::thread thread_;
  bool halting_ = false, released_ = true;
};

} // namespace tactus::devices

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
/// A call into a driver may hang. `owner` then keeps the servo, the device and their data alive
/// while that thread uses them, and stop() returns after its timeout.
class ServoThread {
public:
  ServoThread() = default;
  /// With an owner, a thread that does not end within the timeout of stop() is detached.
  ~ServoThread();
  ServoThread(const ServoThread&) = delete;
  ServoThread& operator=(const ServoThread&) = delete;

  /// Returns an empty text if the thread runs, else one sentence. Without an owner, servo and
  /// device must outlive this object.
  [[nodiscard]] std::string start(haptic::Servo& servo, double period_s,
                                  std::shared_ptr<void> owner = {});
  /// Runs in the device's own thread if it has one (Backend::owns_thread), else in a thread as
  /// above.
  [[nodiscard]] std::string start(haptic::Servo& servo, haptic::Backend& device, double period_s,
                                  std::shared_ptr<void> owner = {});
  /// Requests the end and waits for it: at most `timeout_s`, or without limit when there is no
  /// owner. True if no thread uses the servo any more; if false, call it again. The servo's own
  /// thread writes zero force before it ends.
  [[nodiscard]] bool stop(double timeout_s = 0.5) noexcept;
  [[nodiscard]] bool running() const noexcept { return run_ != nullptr; }
  /// Sets the period, in s, from the next tick on. If the driver's thread steps the servo, the
  /// driver sets the rate and this is the nominal period.
  void set_period(double period_s) noexcept;
  /// Whether the device accepted zero force at the end of the last run; true before the first run.
  [[nodiscard]] bool released() const noexcept { return released_; }
  /// How the thread is scheduled: "fifo", "nice", "other", or "driver" if it is the driver's
  /// thread; empty before this is known.
  [[nodiscard]] std::string_view scheduling() const noexcept;

  /// The clock that the thread runs on.
  [[nodiscard]] static double now_s() noexcept;

private:
  struct Run;
  static void run(Run& run) noexcept;
  static void step_from_driver(void* run) noexcept;
  void halt_driver() noexcept;

  std::shared_ptr<Run> run_; // shared with the thread that steps the servo
  std::thread thread_;
  bool halting_ = false, released_ = true;
};

} // namespace tactus::devices

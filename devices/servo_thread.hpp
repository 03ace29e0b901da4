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

  /// Empty when it runs, else one sentence. Without an owner, servo and device must outlive this.
  [[nodiscard]] std::string start(haptic::Servo& servo, double period_s,
                                  std::shared_ptr<void> owner = {});
  /// Runs in the device's own thread if it has one (Backend::owns_thread), else as above.
  [[nodiscard]] std::string start(haptic::Servo& servo, haptic::Backend& device, double period_s,
                                  std::shared_ptr<void> owner = {});
  /// Requests the end and waits for it: at most `timeout_s`, or without limit when there is no
  /// owner. True when no thread uses the servo any more; false: not yet, call again.
  /// The servo's own thread writes zero force before it ends.
  [[nodiscard]] bool stop(double timeout_s = 0.5) noexcept;
  [[nodiscard]] bool running() const noexcept { return run_ != nullptr; }
  /// s, from the next tick on. In a driver's thread the driver sets the rate: the nominal period.
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

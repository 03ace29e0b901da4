#pragma once

#include "core/haptic/servo.hpp"

#include <atomic>
#include <string_view>
#include <thread>

namespace tactus::devices {

/// Steps a servo on the machine's monotonic clock: in a thread of its own, or in the thread of a
/// device's own driver.
class ServoThread {
public:
  ~ServoThread() { stop(); }
  void start(haptic::Servo& servo, double period_s);
  /// As that device wants it. False when its driver's scheduler does not start.
  [[nodiscard]] bool start(haptic::Servo& servo, haptic::Backend& device, double period_s);
  /// Waits for the tick under way; after it nobody touches the servo.
  void stop() noexcept;
  [[nodiscard]] bool running() const noexcept { return thread_.joinable() || driver_; }
  /// How the thread is scheduled: "fifo", "nice", "other", or "driver" when it is the driver's;
  /// empty before it is known.
  [[nodiscard]] std::string_view scheduling() const noexcept;

  /// The clock that the thread runs on.
  [[nodiscard]] static double now_s() noexcept;

private:
  void run(haptic::Servo& servo, double period_s) noexcept;
  static void follow(void* self) noexcept;

  std::thread thread_;
  haptic::Backend* driver_ = nullptr; // that calls follow
  haptic::Servo* servo_ = nullptr;
  double period_s_ = 1e-3;
  std::atomic<bool> stopping_{false};
  std::atomic<int> scheduling_{-1};
};

} // namespace tactus::devices

#pragma once

#include "core/haptic/servo.hpp"

#include <atomic>
#include <string_view>
#include <thread>

namespace tactus::devices {

/// Steps a servo in a thread of its own on the machine's monotonic clock.
class ServoThread {
public:
  ~ServoThread() { stop(); }
  void start(haptic::Servo& servo, double period_s);
  /// Waits for the tick under way; after it nobody touches the servo.
  void stop() noexcept;
  [[nodiscard]] bool running() const noexcept { return thread_.joinable(); }
  /// How the system schedules the thread: "fifo", "nice" or "other"; empty before it is known.
  [[nodiscard]] std::string_view scheduling() const noexcept;

  /// The clock that the thread runs on.
  [[nodiscard]] static double now_s() noexcept;

private:
  void run(haptic::Servo& servo, double period_s) noexcept;

  std::thread thread_;
  std::atomic<bool> stopping_{false};
  std::atomic<int> scheduling_{-1};
};

} // namespace tactus::devices

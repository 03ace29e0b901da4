#pragma once

#include "core/haptic/device/force_timeout.hpp"

#include <atomic>
#include <chrono>
#include <string>
#include <system_error>
#include <thread>

namespace tactus::devices::force_dimension {

/// Ends the force of a servo that stalls, for a controller without a watchdog: a thread calls
/// end_force repeatedly while the servo has not been between enter() and leave() for 50 ms. Guard
/// and servo never call the vendor's functions at the same time. So the guard cannot help a servo
/// that hangs inside such a call.
class StallGuard {
public:
  ~StallGuard() { stop(); }

  /// Returns an empty text, or a sentence if no thread can start.
  [[nodiscard]] std::string start(void (*end_force)(void* context) noexcept, void* context) {
    stop();
    stopping_ = false;
    seen_s_ = haptic::ForceTimeout::now_s();
    try {
      thread_ = std::thread([this, end_force, context] { watch(end_force, context); });
    } catch (const std::system_error&) {
      return "cannot start a thread for the device: close other programs";
    }
    return {};
  }
  void stop() noexcept {
    stopping_ = true;
    if (thread_.joinable())
      thread_.join();
  }

  /// The servo calls it before its calls of the library and leave() after them. False while the
  /// guard calls the library; the servo then skips the device in this tick.
  [[nodiscard]] bool enter() noexcept { return !busy_.exchange(true, std::memory_order_acquire); }
  void leave() noexcept {
    seen_s_.store(haptic::ForceTimeout::now_s(), std::memory_order_relaxed);
    busy_.store(false, std::memory_order_release);
  }

private:
  void watch(void (*end_force)(void*) noexcept, void* context) noexcept {
    while (!stopping_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (haptic::ForceTimeout::now_s() - seen_s_.load(std::memory_order_relaxed) <
              haptic::ForceTimeout::kTimeout_s ||
          !enter())
        continue;
      end_force(context);
      busy_.store(false, std::memory_order_release);
    }
  }

  std::thread thread_;
  std::atomic<bool> stopping_{false}, busy_{false};
  std::atomic<double> seen_s_{0};
};

} // namespace tactus::devices::force_dimension

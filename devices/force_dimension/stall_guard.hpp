#pragma once

#include "core/haptic/device/force_timeout.hpp"

#include <atomic>
#include <chrono>
#include <string>
#include <system_error>
#include <thread>

namespace tactus::devices::force_dimension {

/// Ends the force of a servo that stalls, for a controller without a watchdog of its own: a thread
/// that calls end_force again and again while the servo has not been between enter() and leave()
/// for 50 ms. The vendor's functions are never called by both at once. A servo that hangs inside
/// one of them cannot be helped from here.
class StallGuard {
public:
  ~StallGuard() { stop(); }

  /// Empty, else a sentence.
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

  /// For the servo, round its calls. False while the guard itself is calling: this tick has no
  /// device.
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

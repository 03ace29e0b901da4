#pragma once

#include "core/haptic/device/device.hpp"

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

namespace tactus {

/// What the opening answers in a thread of its own when it is cancelled after so long.
template <class Open>
std::string cancelled_opening(haptic::Backend& device, Open open, int after_ms = 50) {
  std::string sentence;
  std::atomic<bool> opened{false};
  std::thread opening([&] {
    sentence = open();
    opened = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(after_ms));
  while (!opened) {
    device.cancel();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  opening.join();
  return sentence;
}

inline std::string cancelled_opening(haptic::Backend& device) {
  return cancelled_opening(device, [&] { return device.open(); });
}

} // namespace tactus

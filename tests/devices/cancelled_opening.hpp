#pragma once

#include "core/haptic/device/device.hpp"

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

namespace tactus {

/// What open() answers in a thread of its own when it is cancelled after 50 ms.
inline std::string cancelled_opening(haptic::Backend& device) {
  std::string sentence;
  std::atomic<bool> opened{false};
  std::thread opening([&] {
    sentence = device.open();
    opened = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  while (!opened) {
    device.cancel();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  opening.join();
  return sentence;
}

} // namespace tactus

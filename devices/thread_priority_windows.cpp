#include "devices/thread_priority.hpp"

#include <windows.h>

namespace tactus::devices {

/// Windows has no real-time policy for a user's thread; the highest class that needs no right is
/// TIME_CRITICAL, above all threads of normal programs.
Scheduling raise_thread_priority(int) noexcept {
  return SetThreadPriority(GetCurrentThread(), THREAD_PRIORITY_TIME_CRITICAL) != 0
             ? Scheduling::kNice
             : Scheduling::kOther;
}

} // namespace tactus::devices

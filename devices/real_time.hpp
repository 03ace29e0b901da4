#pragma once

#include <atomic>

/// System functions for a servo's threads, implemented in real_time_posix.cpp and
/// real_time_windows.cpp.
namespace tactus::devices {

/// Lets the calling thread sleep until a time of std::chrono::steady_clock, as precisely as the
/// system can. Each thread needs its own object.
class PreciseSleep {
public:
  PreciseSleep() noexcept;
  ~PreciseSleep(); // NOLINT(performance-trivially-destructible): on Windows it closes a timer
  PreciseSleep(const PreciseSleep&) = delete;
  PreciseSleep& operator=(const PreciseSleep&) = delete;

  /// Returns at once when the time has passed.
  void until(double time_s) noexcept;

private:
  [[maybe_unused]] void* timer_ = nullptr; ///< a timer of Windows
};

/// How the system schedules a thread.
enum class Scheduling { kRealTime, kNice, kOther };

/// Real-time priorities, 1 to 99. A thread that passes the servo's forces to a device runs above
/// the servo, so that a written force is sent at once.
constexpr int kServoPriority = 60, kDeviceThreadPriority = 61;

/// Raises the priority of the calling thread: SCHED_FIFO at `priority` if the system allows it,
/// else a lower nice value, else the default scheduling with a short timer slack. On Windows it
/// takes the highest priority of a normal program and returns kNice; on macOS a time constraint of
/// the servo's rate.
Scheduling raise_thread_priority(int priority) noexcept;

/// Wakes a thread that waits. The waker locks nothing, and no wake-up is lost. std::atomic's own
/// wait is not used, because GCC's library loses some of its wake-ups on Windows
/// (docs/cross_build.md, "What Windows loses").
class WakeCount {
public:
  /// From any thread.
  void wake() noexcept;
  /// Waits until the count differs from `seen`, and returns the new count.
  [[nodiscard]] int wait(int seen) noexcept;

private:
  std::atomic<int> count_{0};
};

} // namespace tactus::devices

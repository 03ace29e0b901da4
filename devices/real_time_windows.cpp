#include "devices/real_time.hpp"

#include <chrono>
#include <thread>

#include <windows.h>

#ifndef CREATE_WAITABLE_TIMER_HIGH_RESOLUTION
#define CREATE_WAITABLE_TIMER_HIGH_RESOLUTION 0x00000002
#endif

namespace tactus::devices {

// Without a timer of high resolution, a sleep ends with the system's tick, up to 15.6 ms late. Such
// timers exist since Windows 10 1803. On older systems a timer is no finer than the tick.
PreciseSleep::PreciseSleep() noexcept
    : timer_(CreateWaitableTimerExW(nullptr, nullptr, CREATE_WAITABLE_TIMER_HIGH_RESOLUTION,
                                    TIMER_ALL_ACCESS)) {
  if (!timer_)
    timer_ = CreateWaitableTimerExW(nullptr, nullptr, 0, TIMER_ALL_ACCESS);
}

PreciseSleep::~PreciseSleep() {
  if (timer_)
    CloseHandle(timer_);
}

void PreciseSleep::until(double time_s) noexcept {
  using Steady = std::chrono::steady_clock;
  const double left_s =
      time_s - std::chrono::duration<double>(Steady::now().time_since_epoch()).count();
  if (left_s <= 0)
    return;
  LARGE_INTEGER due;
  due.QuadPart = -static_cast<LONGLONG>(left_s * 1e7) - 1; // from now, in units of 100 ns
  if (!timer_ || !SetWaitableTimer(timer_, &due, 0, nullptr, nullptr, FALSE))
    std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
  else
    WaitForSingleObject(timer_, INFINITE);
}

/// Windows has no real-time policy for a user's thread. The highest priority that needs no special
/// right is TIME_CRITICAL, above all threads of normal programs.
Scheduling raise_thread_priority(int) noexcept {
  return SetThreadPriority(GetCurrentThread(), THREAD_PRIORITY_TIME_CRITICAL) != 0
             ? Scheduling::kNice
             : Scheduling::kOther;
}

static_assert(sizeof(std::atomic<int>) == sizeof(int) && std::atomic<int>::is_always_lock_free);

void WakeCount::wake() noexcept {
  count_.fetch_add(1, std::memory_order_release);
  WakeByAddressSingle(&count_);
}

int WakeCount::wait(int seen) noexcept {
  for (;;) {
    const int now = count_.load(std::memory_order_acquire);
    if (now != seen)
      return now;
    WaitOnAddress(&count_, &seen, sizeof seen, INFINITE); // returns at once if it has changed
  }
}

} // namespace tactus::devices

#include "devices/real_time.hpp"

#include <chrono>
#include <thread>

#ifdef __linux__
#include <cerrno>
#include <cmath>
#include <ctime>

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#elif defined(__APPLE__)
#include <cstdint>

#include <mach/mach_init.h>
#include <mach/mach_time.h>
#include <mach/thread_act.h>
#include <mach/thread_policy.h>
#include <pthread.h>
#endif

namespace tactus::devices {
#ifdef __APPLE__
namespace {

/// Seconds in the unit of mach_absolute_time().
double mach_ticks(double seconds) noexcept {
  mach_timebase_info_data_t nanoseconds_per_tick{};
  mach_timebase_info(&nanoseconds_per_tick);
  return seconds * 1e9 * nanoseconds_per_tick.denom / nanoseconds_per_tick.numer;
}

} // namespace
#endif

PreciseSleep::PreciseSleep() noexcept = default;
PreciseSleep::~PreciseSleep() = default;

void PreciseSleep::until(double time_s) noexcept {
  using Steady = std::chrono::steady_clock;
  const double left_s =
      time_s - std::chrono::duration<double>(Steady::now().time_since_epoch()).count();
  if (left_s <= 0)
    return;
#ifdef __linux__
  timespec until{};
  const double whole = std::floor(time_s);
  until.tv_sec = static_cast<time_t>(whole);
  until.tv_nsec = static_cast<long>((time_s - whole) * 1e9);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
#elif defined(__APPLE__)
  mach_wait_until(mach_absolute_time() + static_cast<std::uint64_t>(mach_ticks(left_s)));
#else
  std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
#endif
}

Scheduling raise_thread_priority(int priority) noexcept {
#ifdef __linux__
  sched_param parameters{};
  parameters.sched_priority = priority;
  if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0)
    return Scheduling::kRealTime;
  prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL); // otherwise the normal policy wakes the thread 50
                                                // us late
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  if (setpriority(PRIO_PROCESS, thread, -10) == 0)
    return Scheduling::kNice;
#elif defined(__APPLE__)
  // macOS ranks real-time threads by what they need: in every millisecond, a quarter of one of
  // computation, done within half of one; for a device's thread within less.
  const auto ticks = [](double seconds) { return static_cast<std::uint32_t>(mach_ticks(seconds)); };
  thread_time_constraint_policy_data_t policy{};
  policy.period = ticks(1e-3);
  policy.computation = ticks(0.25e-3);
  policy.constraint = ticks(priority > kServoPriority ? 0.3e-3 : 0.5e-3);
  policy.preemptible = 1;
  if (thread_policy_set(pthread_mach_thread_np(pthread_self()), THREAD_TIME_CONSTRAINT_POLICY,
                        reinterpret_cast<thread_policy_t>(&policy),
                        THREAD_TIME_CONSTRAINT_POLICY_COUNT) == KERN_SUCCESS)
    return Scheduling::kRealTime;
#else
  static_cast<void>(priority);
#endif
  return Scheduling::kOther;
}

void WakeCount::wake() noexcept {
  count_.fetch_add(1, std::memory_order_release);
  count_.notify_one();
}

int WakeCount::wait(int seen) noexcept {
  count_.wait(seen, std::memory_order_acquire);
  return count_.load(std::memory_order_acquire);
}

} // namespace tactus::devices

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
#endif

namespace tactus::devices {

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

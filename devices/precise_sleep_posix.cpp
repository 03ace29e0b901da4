#include "devices/precise_sleep.hpp"

#include <chrono>
#include <thread>

#ifdef __linux__
#include <cerrno>
#include <cmath>
#include <ctime>
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

} // namespace tactus::devices

#include "devices/servo_thread.hpp"

#include "devices/signals_held_back.hpp"
#include "devices/thread_priority.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>

#ifdef __linux__
#include <ctime>
#endif
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace tactus::devices {
namespace {

constexpr int kDriversOwn = 3;

using Steady = std::chrono::steady_clock;

struct MonotonicClock final : haptic::Clock {
  double now_s() noexcept override { return ServoThread::now_s(); }
};

void sleep_until(double time_s) noexcept {
  const double left_s = time_s - ServoThread::now_s();
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

} // namespace

double ServoThread::now_s() noexcept {
  return std::chrono::duration<double>(Steady::now().time_since_epoch()).count();
}

std::string_view ServoThread::scheduling() const noexcept {
  constexpr std::array<std::string_view, 5> names{"", "fifo", "nice", "other", "driver"};
  return names[static_cast<std::size_t>(scheduling_.load(std::memory_order_relaxed) + 1)];
}

void ServoThread::start(haptic::Servo& servo, double period_s) {
  stop();
  stopping_ = false;
  scheduling_ = -1;
  const SignalsHeldBack held;
  thread_ = std::thread([this, &servo, period_s] { run(servo, period_s); });
}

bool ServoThread::start(haptic::Servo& servo, haptic::Backend& device, double period_s) {
  if (!device.owns_thread()) {
    start(servo, period_s);
    return true;
  }
  stop();
  servo_ = &servo;
  period_s_ = period_s;
  scheduling_ = kDriversOwn;
  driver_ = &device;
  const SignalsHeldBack held; // the driver's scheduler, too, may start its thread here
  if (!device.run(&ServoThread::follow, this))
    driver_ = nullptr;
  return driver_ != nullptr;
}

void ServoThread::follow(void* self) noexcept {
  MonotonicClock clock;
  auto& thread = *static_cast<ServoThread*>(self);
  thread.servo_->follow(clock, thread.period_s_);
}

void ServoThread::stop() noexcept {
  if (driver_)
    driver_->halt();
  driver_ = nullptr;
  if (!thread_.joinable())
    return;
  stopping_ = true;
  thread_.join(); // within one period: the step is bounded and the sleep ends at the next deadline
}

void ServoThread::run(haptic::Servo& servo, double period_s) noexcept {
  scheduling_ = static_cast<int>(raise_thread_priority(kServoPriority));
#if defined(__SSE2__)
  _mm_setcsr(_mm_getcsr() | 0x8040); // denormals are zero
#endif
  MonotonicClock clock;
  servo.start(clock, period_s);
  while (!stopping_.load(std::memory_order_acquire)) {
    sleep_until(servo.deadline_s());
    servo.wake(clock);
  }
}

} // namespace tactus::devices

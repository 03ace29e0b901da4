#include "devices/servo_thread.hpp"

#include "devices/real_time.hpp"
#include "devices/scoped_signal_mask.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <system_error>

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

} // namespace

double ServoThread::now_s() noexcept {
  return std::chrono::duration<double>(Steady::now().time_since_epoch()).count();
}

struct ServoThread::Run {
  haptic::Servo& servo;
  haptic::Backend* driver; ///< steps the servo; if null, this object's thread does
  std::shared_ptr<void> owner;
  std::atomic<double> period_s;
  std::atomic<bool> stopping{false}, released{true};
  std::atomic<int> scheduling{-1};

  std::mutex mutex{};
  std::condition_variable changed{};
  bool ended = false;

  void end() {
    const std::scoped_lock lock(mutex);
    ended = true;
    changed.notify_all();
  }
};

std::string_view ServoThread::scheduling() const noexcept {
  constexpr std::array<std::string_view, 5> names{"", "fifo", "nice", "other", "driver"};
  const int known = run_ ? run_->scheduling.load(std::memory_order_relaxed) : -1;
  return names[static_cast<std::size_t>(known + 1)];
}

void ServoThread::set_period(double period_s) noexcept {
  if (run_)
    run_->period_s.store(period_s, std::memory_order_relaxed);
}

std::string ServoThread::start(haptic::Servo& servo, double period_s, std::shared_ptr<void> owner) {
  if (!stop())
    return "the servo's previous thread is still waiting for its device";
  auto run = std::shared_ptr<Run>(new Run{servo, nullptr, std::move(owner), {period_s}});
  const ScopedSignalMask held;
  try {
    thread_ = std::thread([run] {
      ServoThread::run(*run);
      run->end();
    });
  } catch (const std::system_error& error) {
    return std::string("cannot start the servo's thread (") + error.what() +
           "): close other programs or raise the limit on threads";
  }
  run_ = std::move(run);
  released_ = true;
  return {};
}

std::string ServoThread::start(haptic::Servo& servo, haptic::Backend& device, double period_s,
                               std::shared_ptr<void> owner) {
  if (!device.owns_thread())
    return start(servo, period_s, std::move(owner));
  if (!stop())
    return "the servo's previous thread is still waiting for its device";
  auto run = std::shared_ptr<Run>(new Run{servo, &device, std::move(owner), {period_s}});
  run->scheduling = kDriversOwn;
  const ScopedSignalMask held; // the driver's scheduler, too, may start its thread here
  if (!device.run(&ServoThread::step_from_driver, run.get())) {
    const std::string reason = device.trouble();
    return "cannot start the device's own scheduler" + (reason.empty() ? "" : ": " + reason);
  }
  run_ = std::move(run);
  halting_ = false;
  released_ = true;
  return {};
}

void ServoThread::step_from_driver(void* run) noexcept {
  MonotonicClock clock;
  auto& self = *static_cast<Run*>(run);
  self.servo.step_from_driver(clock, self.period_s.load(std::memory_order_relaxed));
}

/// Calls the driver's halt(), which writes zero force, in a separate thread, since it may never
/// return.
void ServoThread::halt_driver() noexcept {
  if (halting_)
    return;
  halting_ = true;
  if (run_->owner) {
    const ScopedSignalMask held;
    try {
      std::thread([run = run_] {
        run->driver->halt();
        run->end();
      }).detach();
      return;
    } catch (const std::system_error&) { // no new thread: halt in this thread, however long it
                                         // takes
    }
  }
  run_->driver->halt();
  run_->end();
}

bool ServoThread::stop(double timeout_s) noexcept {
  if (!run_)
    return true;
  if (run_->driver)
    halt_driver();
  run_->stopping = true;
  {
    std::unique_lock lock(run_->mutex);
    const auto ended = [this] { return run_->ended; };
    if (!run_->owner)
      run_->changed.wait(lock, ended);
    else if (!run_->changed.wait_for(lock, std::chrono::duration<double>(timeout_s), ended))
      return false;
  }
  if (thread_.joinable())
    thread_.join(); // its function has ended
  released_ = run_->released.load();
  run_.reset();
  return true;
}

ServoThread::~ServoThread() {
  if (!stop() && thread_.joinable())
    thread_.detach();
}

void ServoThread::run(Run& run) noexcept {
  run.scheduling = static_cast<int>(raise_thread_priority(kServoPriority));
#if defined(__SSE2__)
  _mm_setcsr(_mm_getcsr() | 0x8040); // treats denormals as zero
#endif
  MonotonicClock clock;
  PreciseSleep sleep;
  double period_s = 0;
  while (!run.stopping.load(std::memory_order_acquire)) {
    if (const double wanted_s = run.period_s.load(std::memory_order_relaxed);
        wanted_s != period_s) {
      period_s = wanted_s;
      run.servo.start(clock, period_s);
    }
    sleep.until(run.servo.deadline_s());
    run.servo.wake(clock);
  }
  run.released = run.servo.release();
}

} // namespace tactus::devices

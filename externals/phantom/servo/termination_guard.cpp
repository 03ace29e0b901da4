#include "externals/phantom/servo/termination_guard.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

#ifndef _WIN32
#include <ctime>
#endif

namespace tactus::phantom {
namespace {

// The data that the signal handler reads, without locks and in memory that is never freed.
constexpr int kMaxMotors = 256;
struct Slot {
  std::atomic<haptic::MotorControl*> motors{nullptr};
  std::atomic<bool> taken{false}, driven{false};
};
std::array<Slot, kMaxMotors> slots;
std::atomic<bool> handling{false};
static_assert(std::atomic<haptic::MotorControl*>::is_always_lock_free);

#ifndef _WIN32
template <class Visit> bool all_driven(Visit visit) noexcept {
  bool all = true;
  for (Slot& slot : slots)
    if (haptic::MotorControl* motors = slot.motors.load(); motors && slot.driven.load())
      all = visit(*motors) && all;
  return all;
}

/// Signal handler. Waits up to 200 ms until the servos have written zero force and 50 ms until
/// their drivers have sent it; then the process ends by the signal's default action. Calls only
/// functions that are safe in a signal handler.
void on_termination(int number) {
  const timespec tick{0, 1'000'000}, sending{0, 50'000'000};
  handling = true; // ~TerminationGuard() now waits, so the motors' memory stays valid
  all_driven([](haptic::MotorControl& motors) { return motors.emergency_stop(), true; });
  for (int waited = 0; waited < 200; ++waited) {
    if (all_driven([](haptic::MotorControl& motors) { return motors.zero_force_confirmed(); }))
      break;
    nanosleep(&tick, nullptr);
  }
  nanosleep(&sending, nullptr);
  std::signal(number, SIG_DFL);
  std::raise(number);
}

void guard_termination() noexcept {
  struct sigaction now {};
  if (sigaction(SIGTERM, nullptr, &now) == 0 && !(now.sa_flags & SA_SIGINFO) &&
      now.sa_handler == SIG_DFL)
    std::signal(SIGTERM, &on_termination);
}
#else
void guard_termination() noexcept {}
#endif

} // namespace

TerminationGuard::TerminationGuard(haptic::MotorControl& motors) noexcept {
  for (int i = 0; i < kMaxMotors && slot_ < 0; ++i)
    if (!slots[static_cast<std::size_t>(i)].taken.exchange(true))
      slot_ = i;
  if (slot_ >= 0)
    slots[static_cast<std::size_t>(slot_)].motors = &motors;
}

TerminationGuard::~TerminationGuard() {
  if (slot_ < 0)
    return;
  Slot& slot = slots[static_cast<std::size_t>(slot_)];
  slot.motors = nullptr;
  slot.driven = false;
  // Either the handler reads null, or this thread sees that the handler runs; the handler then ends
  // the process.
  while (handling)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  slot.taken = false;
}

void TerminationGuard::set_driven(bool driven) noexcept {
  if (slot_ >= 0)
    slots[static_cast<std::size_t>(slot_)].driven = driven;
  if (driven)
    guard_termination();
}

} // namespace tactus::phantom

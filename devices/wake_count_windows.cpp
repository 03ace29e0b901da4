#include "devices/wake_count.hpp"

#include <windows.h>

namespace tactus::devices {

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

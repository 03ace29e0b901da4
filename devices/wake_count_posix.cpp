#include "devices/wake_count.hpp"

namespace tactus::devices {

void WakeCount::wake() noexcept {
  count_.fetch_add(1, std::memory_order_release);
  count_.notify_one();
}

int WakeCount::wait(int seen) noexcept {
  count_.wait(seen, std::memory_order_acquire);
  return count_.load(std::memory_order_acquire);
}

} // namespace tactus::devices

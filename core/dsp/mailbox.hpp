#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace tactus {

/// Passes the newest value from one writing thread to one reading thread: a triple buffer. Both
/// sides are wait-free, a value is never torn, and older values are dropped on purpose.
template <class T> class Mailbox {
public:
  void write(const T& value) noexcept {
    slots_[back_] = value;
    back_ = middle_.exchange(back_ | kNewValue, std::memory_order_acq_rel) & kIndex;
  }

  /// True when something was written since the last read; latest() is then that value.
  bool read() noexcept {
    if (!(middle_.load(std::memory_order_relaxed) & kNewValue))
      return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  /// The value of the last read. For the reading thread.
  [[nodiscard]] const T& latest() const noexcept { return slots_[front_]; }

private:
  static constexpr std::uint32_t kIndex = 3, kNewValue = 4;
  std::array<T, 3> slots_{};
  std::uint32_t back_ = 0, front_ = 2;
  std::atomic<std::uint32_t> middle_{1};
};

} // namespace tactus

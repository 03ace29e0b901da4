#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace tactus {

/// A ring buffer from one writing thread to one reading thread. Both sides are wait-free. A value
/// that does not fit is dropped and counted. Capacity is a power of two.
template <class T, std::size_t Capacity> class Ring {
  static_assert(Capacity > 0 && (Capacity & (Capacity - 1)) == 0);

public:
  /// False when the ring is full.
  bool push(const T& value) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == Capacity) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    slots_[end % Capacity] = value;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  /// False when the ring is empty; `value` then stays as it is.
  bool pop(T& value) noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire))
      return false;
    value = slots_[begin % Capacity];
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }

  /// Number of values to read. For the reading thread.
  [[nodiscard]] std::size_t size() const noexcept {
    return end_.load(std::memory_order_acquire) - begin_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::uint64_t dropped() const noexcept {
    return dropped_.load(std::memory_order_relaxed);
  }

private:
  std::array<T, Capacity> slots_{};
  std::atomic<std::size_t> begin_{0}, end_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

} // namespace tactus

#pragma once

#include "core/object.hpp"

#include <atomic>
#include <cstddef>
#include <vector>

/// A copy of the parameters' values that any thread can read without the object's token.
namespace tactus::max {

class ParameterView {
public:
  explicit ParameterView(std::size_t count) : slots_(count) {}

  /// The last requested value, until the object has applied it; otherwise the object's value.
  [[nodiscard]] double value(std::size_t i) const noexcept {
    const Slot& slot = slots_[i];
    return slot.pending.load(std::memory_order_acquire) > 0
               ? slot.asked.load(std::memory_order_relaxed)
               : slot.held.load(std::memory_order_relaxed);
  }
  void ask(std::size_t i, double value) noexcept {
    slots_[i].asked.store(value, std::memory_order_relaxed);
    slots_[i].pending.fetch_add(1, std::memory_order_release);
  }
  void answer(std::size_t i) noexcept { slots_[i].pending.fetch_sub(1, std::memory_order_release); }
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  /// Reads all values of the object and marks those that have changed. The parameter that was set
  /// is marked only if its value differs from the requested one, which its setter already has.
  /// Returns true if any value has changed. For the holder of the object's token.
  bool refresh(const AnyObject<double>& object, std::size_t set = kNone) noexcept {
    bool any = false;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      Slot& slot = slots_[i];
      const double now = object.get(i);
      if (now == slot.held.load(std::memory_order_relaxed))
        continue;
      slot.held.store(now, std::memory_order_relaxed);
      any = true;
      if (i != set || now != slot.asked.load(std::memory_order_relaxed))
        slot.changed.store(true, std::memory_order_release);
    }
    return any;
  }
  /// Whether the value has changed since the last call.
  [[nodiscard]] bool take_change(std::size_t i) noexcept {
    return slots_[i].changed.exchange(false, std::memory_order_acquire);
  }

private:
  struct Slot {
    std::atomic<double> asked{0}, held{0};
    std::atomic<int> pending{0};
    std::atomic<bool> changed{false};
  };
  std::vector<Slot> slots_;
};

} // namespace tactus::max

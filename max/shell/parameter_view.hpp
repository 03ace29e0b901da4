#pragma once

#include "core/object.hpp"

#include <atomic>
#include <cstddef>
#include <vector>

/// The parameters' values for whoever asks, in any thread, without the object's token.
namespace tactus::max {

class ParameterView {
public:
  explicit ParameterView(std::size_t count) : slots_(count) {}

  /// What the object will have: the value that was asked for last, until it is applied.
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
  /// Reads all values of the object. For the holder of its token.
  void refresh(const AnyObject<double>& object) noexcept {
    for (std::size_t i = 0; i < slots_.size(); ++i)
      slots_[i].held.store(object.get(i), std::memory_order_relaxed);
  }

private:
  struct Slot {
    std::atomic<double> asked{0}, held{0};
    std::atomic<int> pending{0};
  };
  std::vector<Slot> slots_;
};

} // namespace tactus::max

#pragma once

#include <atomic>

/// The right to use an object, held by one thread at a time. The audio thread never waits for it.
namespace tactus::max {

class Token {
public:
  enum class Holder { kNobody, kMessage, kAudio };

  /// One try; false while somebody holds it. What the last holder wrote is visible afterwards.
  [[nodiscard]] bool take(Holder by) noexcept {
    Holder expected = Holder::kNobody;
    return holder_.compare_exchange_strong(expected, by);
  }
  void release() noexcept { holder_.store(Holder::kNobody); }
  [[nodiscard]] Holder holder() const noexcept { return holder_.load(); }

private:
  // In one order with the queue's own atomics: see Executor::carry_out_all().
  std::atomic<Holder> holder_{Holder::kNobody};
};

} // namespace tactus::max

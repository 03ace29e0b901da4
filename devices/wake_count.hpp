#pragma once

#include <atomic>

namespace tactus::devices {

/// Wakes a thread that waits. The waker locks nothing, and no wake-up is lost: not std::atomic's
/// own wait, in which GCC's library loses some on Windows (docs/cross_build.md, "What Windows
/// loses").
class WakeCount {
public:
  /// From any thread.
  void wake() noexcept;
  /// Waits until the count is another than `seen`, and returns it.
  [[nodiscard]] int wait(int seen) noexcept;

private:
  std::atomic<int> count_{0};
};

} // namespace tactus::devices

#pragma once

namespace tactus::devices {

/// Lets the calling thread sleep until a time of std::chrono::steady_clock, as precisely as the
/// system can. One for a thread.
class PreciseSleep {
public:
  PreciseSleep() noexcept;
  ~PreciseSleep(); // NOLINT(performance-trivially-destructible): on Windows it closes a timer
  PreciseSleep(const PreciseSleep&) = delete;
  PreciseSleep& operator=(const PreciseSleep&) = delete;

  /// Returns at once when the time has passed.
  void until(double time_s) noexcept;

private:
  [[maybe_unused]] void* timer_ = nullptr; ///< of Windows
};

} // namespace tactus::devices

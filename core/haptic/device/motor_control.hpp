#pragma once

#include <atomic>
#include <cstdint>

namespace tactus::haptic {

/// Motors on, off and emergency stop, from the host to the servo, and the servo's confirmation.
/// Request and confirmation are one atomic word each, not a queue: the newest request wins, and a
/// stop never waits behind other requests. Requests may come from any thread and from a signal
/// handler.
class MotorControl {
public:
  struct Request {
    bool on = true;                 ///< `motors 1`; else the force falls at the slew limit
    bool stopped = false;           ///< an `estop` that no `motors 1` has ended
    bool paused = false;            ///< as `on` = false, but set by the program and not by the user
    std::uint32_t stop_count = 0;   ///< number of estops
    std::uint32_t enable_count = 0; ///< number of enables
    bool operator==(const Request&) const = default;
  };

  /// Switches the motors on over the chain's enable time; ends an emergency stop and a device's
  /// failure.
  void enable() noexcept {
    change([](Request& r) { r.on = true, r.stopped = false, ++r.enable_count; });
  }
  void disable() noexcept {
    change([](Request& r) { r.on = false; });
  }
  /// No force from the servo's next tick on, until enable().
  void emergency_stop() noexcept {
    change([](Request& r) { r.stopped = true, ++r.stop_count; });
  }
  /// Lets the force fall at the slew limit, or rise again, independent of the other requests.
  void pause(bool paused) noexcept {
    change([paused](Request& r) { r.paused = paused; });
  }
  [[nodiscard]] Request request() const noexcept {
    return unpack(requested_.load(std::memory_order_acquire));
  }
  /// Copies the request of a servo that is being replaced, except its pause.
  void take_over(const MotorControl& other) noexcept {
    Request request = other.request();
    request.paused = false;
    requested_.store(pack(request), std::memory_order_release);
  }

  /// The servo's side: a force was written while this request was in effect.
  void confirm(const Request& request, bool zero_force) noexcept {
    confirmed_.store(pack(request) | (zero_force ? kZeroForce : 0), std::memory_order_release);
  }
  /// The newest request is in effect and the last force written was zero.
  [[nodiscard]] bool zero_force_confirmed() const noexcept {
    return confirmed_.load(std::memory_order_acquire) ==
           (requested_.load(std::memory_order_acquire) | kZeroForce);
  }

private:
  using Word = std::uint64_t;
  static_assert(std::atomic<Word>::is_always_lock_free); // for signal handlers
  static constexpr Word kOn = 1, kStopped = 2, kPaused = 4, kZeroForce = 8;
  static constexpr int kStopsShift = 4, kEnablesShift = 34;
  static constexpr Word kCount = (Word{1} << 30) - 1;

  [[nodiscard]] static constexpr Word pack(const Request& r) noexcept {
    return (r.on ? kOn : 0) | (r.stopped ? kStopped : 0) | (r.paused ? kPaused : 0) |
           (r.stop_count & kCount) << kStopsShift | (r.enable_count & kCount) << kEnablesShift;
  }
  [[nodiscard]] static constexpr Request unpack(Word word) noexcept {
    return {(word & kOn) != 0, (word & kStopped) != 0, (word & kPaused) != 0,
            static_cast<std::uint32_t>(word >> kStopsShift & kCount),
            static_cast<std::uint32_t>(word >> kEnablesShift & kCount)};
  }
  template <class Change> void change(Change&& apply) noexcept {
    Word before = requested_.load(std::memory_order_relaxed), after = 0;
    do {
      Request request = unpack(before);
      apply(request);
      after = pack(request);
    } while (!requested_.compare_exchange_weak(before, after, std::memory_order_acq_rel,
                                               std::memory_order_relaxed));
  }

  std::atomic<Word> requested_{pack({})}, confirmed_{0};
};

} // namespace tactus::haptic

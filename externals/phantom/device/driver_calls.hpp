#pragma once

#include "externals/phantom/device/driver_use.hpp"
#include "files/background_thread.hpp"

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

namespace tactus::phantom {

/// What a thread that calls drivers is at. A call may take seconds or never return: its owner
/// cancels an opening that is not wanted any more, and names a call that hangs.
class DriverCalls {
public:
  using Device = std::shared_ptr<haptic::Backend>;

  // The thread's side.
  /// A call while it lives. `opened`: the device, if it opens one, and the ticket of that.
  class Call {
  public:
    Call(DriverCalls& calls, std::string what, Device opened = {}, std::uint64_t ticket = 0);
    ~Call();
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

  private:
    DriverCalls& calls_;
  };
  /// The driver is used from now on, or no more.
  void set_use(std::unique_ptr<DriverUse> use);
  /// The device is open, or about to be closed.
  void opened(haptic::Identity identity);
  void leave();

  // The owner's side.
  /// Openings of another ticket are not wanted any more.
  void want(std::uint64_t ticket);
  /// Nor any device.
  void want_none();
  /// Asks an abandoned opening to end. To be repeated while there is something to do.
  void cancel_unwanted();
  /// The call that has not returned for longer than `limit_s` after it was abandoned, such as
  /// "closing the device"; empty when there is none.
  [[nodiscard]] std::string overdue(double limit_s) const;

  /// Whether a thread makes calls, or may.
  static void set_running(const std::shared_ptr<DriverCalls>& calls, bool running);
  /// At the end of the host's program, when all owners have gone: waits until their threads have
  /// ended, up to `seconds` in all, and names the calls that still hang on the standard error.
  /// Whether all have ended.
  static bool join_all(double seconds) noexcept;

private:
  void abandon(std::uint64_t wanted, bool for_good);

  mutable std::mutex mutex_;
  std::string call_; ///< empty: none
  Device called_;    ///< the device, if the call opens one
  std::uint64_t call_ticket_ = 0, wanted_ = 0;
  double since_s_ = 0; ///< when it began or, of an opening, was abandoned; 0: still wanted
  std::unique_ptr<DriverUse> use_;
};

/// A thread that calls drivers. It keeps the host's priority, which threads of the drivers inherit,
/// and DriverCalls::join_all() waits for it instead of the end of all others.
class DriverThread {
public:
  DriverThread() = default;
  ~DriverThread();
  DriverThread(const DriverThread&) = delete;
  DriverThread& operator=(const DriverThread&) = delete;
  [[nodiscard]] bool running() const noexcept { return state_ != nullptr; }
  [[nodiscard]] std::string start(std::shared_ptr<BackgroundState> state);

private:
  std::shared_ptr<BackgroundState> state_;
};

} // namespace tactus::phantom

#pragma once

#include "externals/phantom/device/driver_use.hpp"
#include "files/background_thread.hpp"

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

namespace tactus::phantom {

/// The current call of a thread that calls drivers. A call may take seconds or never return. The
/// thread's owner can cancel an opening that is no longer requested, and can name a call that
/// hangs.
class DriverCalls {
public:
  using Device = std::shared_ptr<haptic::Backend>;

  // Used by the thread.
  /// Marks a call as running while this object lives. `opened`: the device that the call opens, if
  /// any; `ticket`: the ticket of that opening.
  class Call {
  public:
    Call(DriverCalls& calls, std::string what, Device opened = {}, std::uint64_t ticket = 0);
    ~Call();
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

  private:
    DriverCalls& calls_;
  };
  /// Marks the driver as in use from now on; null: no longer.
  void set_use(std::unique_ptr<DriverUse> use);
  /// Reports that the device is open (opened()) or about to be closed (leave()).
  void opened(haptic::Identity identity);
  void leave();

  // Used by the owner.
  /// Abandons all openings with another ticket.
  void want(std::uint64_t ticket);
  /// Abandons all openings, for good.
  void want_none();
  /// Asks an abandoned opening to end. Call it repeatedly while the thread is busy.
  void cancel_unwanted();
  /// The name of a call, such as "closing the device", that has not returned for longer than
  /// `limit_s` after it was abandoned; empty if there is none.
  [[nodiscard]] std::string overdue(double limit_s) const;

  /// Sets whether a thread makes calls or may make them.
  static void set_running(const std::shared_ptr<DriverCalls>& calls, bool running);
  /// At the end of the host's program, when all owners have gone: waits until their threads have
  /// ended, up to `seconds` in all, and names the calls that still hang on the standard error.
  /// Returns whether all have ended.
  static bool join_all(double seconds) noexcept;

private:
  void abandon(std::uint64_t wanted, bool for_good);

  mutable std::mutex mutex_;
  std::string call_; ///< name of the running call; empty if there is none
  Device called_;    ///< the device, if the call opens one
  std::uint64_t call_ticket_ = 0, wanted_ = 0;
  double since_s_ = 0; ///< start of the call, or for an opening the time when it was abandoned; 0
                       ///< if still requested
  std::unique_ptr<DriverUse> use_;
};

/// A thread that calls drivers. It keeps the host's priority, which threads of the drivers inherit,
/// and at the end of the program DriverCalls::join_all() waits for it, not BackgroundThread's end.
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

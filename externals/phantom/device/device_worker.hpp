#pragma once

#include "devices/driver.hpp"
#include "devices/servo_thread.hpp"
#include "externals/phantom/device/driver_calls.hpp"
#include "externals/phantom/servo/servo_rig.hpp"
#include "files/worker.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tactus::phantom {

/// Opens, runs and closes the device that is wanted. It owns what it works on, and its last act in
/// its thread is to close the device.
class DeviceJob {
public:
  using Device = DriverCalls::Device;

  /// A servo that runs on a device: the rig that its steps use, and the thread that steps it.
  struct Session {
    std::shared_ptr<ServoRig> rig;
    std::shared_ptr<devices::ServoThread> runner;
  };
  struct Request {
    /// Another number than that of the open device closes it first: the session, if there is one,
    /// ends, whose motors the owner has paused, with up to 200 ms for zero force.
    std::uint64_t ticket = 0;
    const devices::Driver* driver = nullptr;
    Device device{}; ///< to be open; null: none
    bool persists =
        false;         ///< tries again after 0.25, 0.5, 1, 2 and then every 4 s, until it is open
    Session session{}; ///< to run on the open device; empty: none yet
    double period_s = 0;
  };
  struct Answer {
    enum class Kind {
      kOpened,
      kRefused, ///< the device was not opened
      kTrouble, ///< the same, and it is tried again: the driver's sentence, when it changes
      kRunning,
      kNotRunning ///< the servo was not started
    };
    Kind kind = Kind::kRefused;
    std::uint64_t ticket = 0; ///< the request's
    std::string sentence{};   ///< the reason of a refusal
  };
  static constexpr const char* kOutOfMemory = "not enough memory for the device";

  explicit DeviceJob(std::shared_ptr<DriverCalls> calls) : calls_(std::move(calls)) {}
  double work(const Request& request, Turn<Answer>& turn);
  void end();

private:
  [[nodiscard]] double open(const Request& request, Turn<Answer>& turn);
  [[nodiscard]] std::string try_open(const Request& request, const Turn<Answer>& turn);
  void run(const Request& request, Turn<Answer>& turn);
  [[nodiscard]] bool close();

  std::shared_ptr<DriverCalls> calls_;
  Request open_;                        ///< what is open and runs; without a device: nothing
  std::uint64_t ticket_ = 0;            ///< of the last opening that was begun
  double pause_s_ = 0;                  ///< until the next
  std::optional<std::string> reported_; ///< its last trouble
};

/// Lists the devices of all drivers.
class ListJob {
public:
  struct Request {
    std::uint64_t ticket = 0;
  };
  struct Answer {
    std::vector<devices::Found> found;
    std::vector<std::pair<std::string, std::string>> problems; ///< drivers that cannot work
  };
  static constexpr const char* kOutOfMemory = "not enough memory for a list of devices";

  explicit ListJob(std::shared_ptr<DriverCalls> calls) : calls_(std::move(calls)) {}
  double work(const Request& request, Turn<Answer>& turn);
  void end() { DriverCalls::set_running(calls_, false); }

private:
  std::shared_ptr<DriverCalls> calls_;
};

/// A worker whose job calls drivers. The host's thread waits for none of these calls.
template <class Job> class DriverWorker {
public:
  /// `ready` is called in the thread after each answer, until this object ends.
  explicit DriverWorker(std::function<void()> ready) { worker_.on_ready(std::move(ready)); }
  /// Does not wait: what is being opened is abandoned, what is open is closed in the thread.
  ~DriverWorker() { calls_->want_none(); }
  DriverWorker(const DriverWorker&) = delete;
  DriverWorker& operator=(const DriverWorker&) = delete;

  /// An opening of an earlier ticket is abandoned; a device that opens all the same is closed.
  /// Returns empty, or why there is no thread.
  [[nodiscard]] std::string request(const typename Job::Request& request) {
    DriverCalls::set_running(calls_, true);
    calls_->want(request.ticket);
    std::string refusal = worker_.request(request);
    if (!refusal.empty())
      DriverCalls::set_running(calls_, false);
    return refusal;
  }
  [[nodiscard]] auto take() { return worker_.take(); }
  [[nodiscard]] bool busy() const { return worker_.busy(); }
  void cancel_unwanted() { calls_->cancel_unwanted(); }
  [[nodiscard]] std::string overdue(double limit_s) const { return calls_->overdue(limit_s); }

private:
  std::shared_ptr<DriverCalls> calls_ = std::make_shared<DriverCalls>();
  Worker<Job, DriverThread> worker_{calls_};
};

using DeviceWorker = DriverWorker<DeviceJob>;
using DeviceLister = DriverWorker<ListJob>;

} // namespace tactus::phantom

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

/// Opens, runs and closes the requested device. It owns all data that it uses. The last thing that
/// it does in its thread is to close the device.
class DeviceJob {
public:
  using Device = DriverCalls::Device;

  /// A servo that runs on a device: the rig that its steps use, and the thread that steps it.
  struct Session {
    std::shared_ptr<ServoRig> rig;
    std::shared_ptr<devices::ServoThread> runner;
  };
  struct Request {
    /// If it differs from the open device's number, that device is closed first. A session of that
    /// device ends, with up to 200 ms for zero force; the owner must have paused its motors.
    std::uint64_t ticket = 0;
    const devices::Driver* driver = nullptr;
    Device device{};       ///< the device to be open, null for none
    bool persists = false; ///< if true, tries to open after 0.25, 0.5, 1, 2 and then every 4 s
    Session session{};     ///< session to run on the open device; empty if none yet
    double period_s = 0;
  };
  struct Answer {
    enum class Kind {
      kOpened,
      kRefused, ///< the device was not opened
      kTrouble, ///< not opened and tried again; sent when the sentence changes
      kRunning,
      kNotRunning ///< the servo was not started
    };
    Kind kind = Kind::kRefused;
    std::uint64_t ticket = 0; ///< the request's ticket
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
  Request open_;                        ///< the open device and its session; no device: nothing is
                                        ///< open
  std::uint64_t ticket_ = 0;            ///< ticket of the last opening that began
  double pause_s_ = 0;                  ///< pause until the next attempt
  std::optional<std::string> reported_; ///< last reported trouble of this opening
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

/// A worker whose job calls drivers. The host's thread does not wait for these calls.
template <class Job> class DriverWorker {
public:
  /// `ready` is called in the worker's thread after each answer, until this object is destroyed.
  explicit DriverWorker(std::function<void()> ready) { worker_.on_ready(std::move(ready)); }
  /// Does not wait. A device that is being opened is abandoned; an open device is closed in the
  /// thread.
  ~DriverWorker() { calls_->want_none(); }
  DriverWorker(const DriverWorker&) = delete;
  DriverWorker& operator=(const DriverWorker&) = delete;

  /// An opening with an earlier ticket is abandoned; if its device opens all the same, that device
  /// is closed. Returns an empty text, or the reason why there is no thread.
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

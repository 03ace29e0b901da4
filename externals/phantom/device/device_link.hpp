#pragma once

#include "core/haptic/device/simulated_device.hpp"
#include "externals/phantom/device/device_worker.hpp"
#include "externals/phantom/servo/servo_session.hpp"
#include "externals/phantom/words.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace tactus::phantom {

/// The chosen device: the simulated one, or one of a driver. A worker opens, runs and closes real
/// devices, since a call of a driver may take seconds or never return. The host's thread waits for
/// none of these calls: it makes requests and takes the answers.
class DeviceLink {
public:
  enum class State { kClosed, kOpening, kOpen, kLost };
  using Device = DeviceJob::Device;

  explicit DeviceLink(ServoSession& session);

  haptic::SimulatedDevice simulated{};
  State state = State::kClosed;

  [[nodiscard]] bool is_real() const noexcept { return driver_ != nullptr; }
  [[nodiscard]] bool is_open() const noexcept { return state == State::kOpen; }
  [[nodiscard]] std::string_view driver_name() const noexcept;
  /// The open device, or the simulated one.
  [[nodiscard]] const haptic::Backend& device() const noexcept;
  /// Time between two ticks: the driver's, if it steps the servo, or that of the patch.
  [[nodiscard]] double period_s() const noexcept;
  /// A thread steps the real device's servo.
  [[nodiscard]] bool runs() const noexcept { return runs_; }

  /// `driver`: null for the simulated device. What was chosen before must be closed.
  void choose(const devices::Driver* driver, Device device) noexcept;
  /// Chooses one of the driver's devices by the words after `open`; a sentence when it refuses.
  [[nodiscard]] std::string select(Words which) const;
  /// The messages driver, firmware, home and calibrate.
  void configure(const Message& row, Words words, Host& host);
  /// The message devices. `name`: of the simulated device.
  void list(std::string_view name, Host& host);
  void send_identity(Host& host) const;
  /// Connects the servo with the device.
  void attach() noexcept;
  /// The patch's rate has changed.
  void change_rate() noexcept;

  /// Requests to the worker; empty, or why there is no thread. `persists`: again and again until it
  /// is open.
  [[nodiscard]] std::string request_open(Host& host, bool persists = false);
  [[nodiscard]] std::string request_run(Host& host);
  [[nodiscard]] std::string request_close(Host& host);
  /// The answer to the newest request. Lists of devices are sent.
  [[nodiscard]] std::optional<DeviceJob::Answer> take(Host& host);
  [[nodiscard]] bool busy() const { return worker_ && worker_->busy(); }
  /// Cancels an opening that is not wanted any more. Names a call that has not returned for long:
  /// its thread is abandoned, and ends when the call returns.
  [[nodiscard]] std::string abandon_overdue();
  /// Ends the threads, which close the device; does not wait.
  void let_go() noexcept;

private:
  [[nodiscard]] std::string request(const DeviceJob::Request& request, Host& host);

  ServoSession& session_;
  const devices::Driver* driver_ = nullptr; ///< null: the simulated device
  Device device_{};                         ///< the driver's
  std::uint64_t ticket_ = 0;                ///< of the newest request to open or close
  bool runs_ = false;
  std::unique_ptr<DeviceWorker> worker_;
  std::unique_ptr<DeviceLister> lister_;
};

} // namespace tactus::phantom

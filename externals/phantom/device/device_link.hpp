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

/// The chosen device: the simulated device, or a driver's device. A worker opens, runs and closes
/// real devices, since a call of a driver may take seconds or never return. The host's thread does
/// not wait for these calls; it makes requests and takes the answers.
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
  /// The open device, or the simulated device if none is open.
  [[nodiscard]] const haptic::Backend& device() const noexcept;
  /// Time between two ticks. The driver sets it if the driver steps the servo; otherwise the patch
  /// does.
  [[nodiscard]] double period_s() const noexcept;
  /// True if a thread steps the real device's servo.
  [[nodiscard]] bool runs() const noexcept { return runs_; }

  /// `driver` is null for the simulated device. The previous device must be closed.
  void choose(const devices::Driver* driver, Device device) noexcept;
  /// Chooses one of the driver's devices by the words after `open`. Returns a sentence if the
  /// driver refuses.
  [[nodiscard]] std::string select(Words which) const;
  /// Handles the messages `driver`, `firmware`, `home` and `calibrate`.
  void configure(const Message& row, Words words, Host& host);
  /// Handles the message `devices`; `name` is the simulated device's name.
  void list(std::string_view name, Host& host);
  void send_identity(Host& host) const;
  /// Connects the servo with the device.
  void attach() noexcept;
  /// Call it when the patch's rate has changed.
  void change_rate() noexcept;

  /// Requests to the worker. They return an empty string, or why there is no thread. With
  /// `persists`, the worker tries again and again until the device is open.
  [[nodiscard]] std::string request_open(Host& host, bool persists = false);
  [[nodiscard]] std::string request_run(Host& host);
  [[nodiscard]] std::string request_close(Host& host);
  /// Returns the answer to the newest request, if there is one. Sends lists of devices to the host.
  [[nodiscard]] std::optional<DeviceJob::Answer> take(Host& host);
  [[nodiscard]] bool busy() const { return worker_ && worker_->busy(); }
  /// Cancels an opening that is no longer wanted. If a call has not returned for a long time,
  /// returns its name and abandons its thread, which ends when the call returns.
  [[nodiscard]] std::string abandon_overdue();
  /// Ends the threads, which close the device. Does not wait for them.
  void let_go() noexcept;

private:
  [[nodiscard]] std::string request(const DeviceJob::Request& request, Host& host);

  ServoSession& session_;
  const devices::Driver* driver_ = nullptr; ///< null for the simulated device
  Device device_{};                         ///< the driver's device
  std::uint64_t ticket_ = 0;                ///< ticket of the newest request to open or close
  bool runs_ = false;
  std::unique_ptr<DeviceWorker> worker_;
  std::unique_ptr<DeviceLister> lister_;
};

} // namespace tactus::phantom

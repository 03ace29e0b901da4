#pragma once

#include "core/haptic/device/device.hpp"
#include "devices/open_devices.hpp"
#include "devices/openhaptics/hd_library.hpp"

#include <atomic>
#include <mutex>

namespace tactus::devices::openhaptics {

/// A PHANTOM or Touch of 3D Systems through the vendor's OpenHaptics library (HDAPI). The vendor's
/// scheduler owns the servo thread: run() registers a callback in which the servo's step runs,
/// between the begin and the end of a frame. Force stays zero until the device is calibrated. After
/// an error that switches force off, force returns once zero has been requested for 0.2 s.
class Device final : public haptic::Backend {
public:
  ~Device() override { close(); }

  [[nodiscard]] std::string open() override;
  /// Takes effect between two calls of the vendor's library; it does not end a call that hangs.
  void cancel() noexcept override { cancelled_ = true; }
  void close() noexcept override;
  [[nodiscard]] haptic::Caps caps() const noexcept override { return caps_; }
  [[nodiscard]] bool read(const haptic::Tick& tick, haptic::State& state) noexcept override;
  [[nodiscard]] bool write(const Vec3& force_n) noexcept override;
  void set_wrist(const haptic::WristCommand& command) noexcept override;
  /// "device NAME": the device's name in the vendor's setup tool. "home" or "calibrate": the
  /// vendor's library checks the calibration again.
  [[nodiscard]] std::string configure(std::span<const std::string> words) override;
  [[nodiscard]] haptic::Identity identity() const override { return identity_; }
  [[nodiscard]] std::string trouble() const override;

  [[nodiscard]] bool owns_thread() const noexcept override { return true; }
  [[nodiscard]] bool run(void (*step)(void* context), void* context) override;
  void halt() noexcept override;

private:
  static unsigned int on_tick(void* self) noexcept;
  [[nodiscard]] bool tick() noexcept;
  void update_calibration_status() noexcept;
  void update_calibration(bool requested) noexcept;
  void check_error(Code error, bool warm) noexcept;
  void send(const Vec3& force_n, const Vec3& torque_n_m) noexcept;
  [[nodiscard]] std::string try_names(const std::string& requested);

  HdLibrary library_;
  OpenDevice open_;
  std::atomic<bool> cancelled_{false};
  Handle handle_ = kNoDevice;
  haptic::Caps caps_{};
  haptic::Identity identity_{};

  std::mutex settings_mutex_;
  std::string requested_name_;

  // Used by the scheduler's thread.
  void (*step_)(void*) = nullptr;
  void* context_ = nullptr;
  SchedulerHandle scheduled_ = 0;
  Code calibration_ = kCalibrationNeedsUpdate;
  int until_calibration_check_ = 0, calibrated_ticks_ = 0;
  int error_ticks_left_ = 0, warm_ticks_left_ = 0, error_free_ticks_ = 0;
  bool force_off_ = false;
  Vec3 last_position_{};
  Vec3 torque_n_m_{};          // for the next write
  bool torque_driven_ = false; // driven since the opening; if true, zero is sent too

  // Shared by the scheduler's thread and others.
  std::atomic<bool> running_{false}, stopping_{false}, stepping_{false}, finished_{false};
  std::atomic<bool> calibration_requested_{false}, needs_reset_position_{false};
  std::atomic<Code> error_{kSuccess}, calibration_status_{kCalibrated};
};

} // namespace tactus::devices::openhaptics

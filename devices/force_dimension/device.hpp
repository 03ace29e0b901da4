#pragma once

#include "core/haptic/device/device.hpp"
#include "core/haptic/device/force_timeout.hpp"
#include "devices/force_dimension/auto_init.hpp"
#include "devices/force_dimension/dhd_library.hpp"
#include "devices/force_dimension/stall_guard.hpp"
#include "devices/open_devices.hpp"

#include <array>
#include <atomic>
#include <mutex>

namespace tactus::devices::force_dimension {

/// An omega, delta, sigma or lambda of Force Dimension through the vendor's library (DHD). The
/// device's own watchdog is set to 30 ms, so that it ends the force when the servo dies. If the
/// device has no watchdog, a StallGuard ends the force. If the device has switched its force off by
/// itself, force returns after zero has been requested for 0.2 s. If its force button has switched
/// the force off, force returns when the button is pressed again. The library's frame (x towards
/// the user, y right, z up) is converted to the project's.
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
  /// "device WHICH": an index below 64, else a serial number. "home" or "calibrate": a device with
  /// automatic initialisation moves itself with its motors; any other device waits to be calibrated
  /// again.
  [[nodiscard]] std::string configure(std::span<const std::string> words) override;
  [[nodiscard]] haptic::Identity identity() const override { return identity_; }
  [[nodiscard]] std::string trouble() const override;

private:
  [[nodiscard]] int open_requested(int requested);
  [[nodiscard]] std::string open_with_retries(int requested);
  [[nodiscard]] bool set_watchdog(unsigned char steps) noexcept;
  void detect_wrist() noexcept;
  [[nodiscard]] int send(const Vec3& force_n, const haptic::WristCommand& wrist) noexcept;
  [[nodiscard]] bool read_device(haptic::State& state) noexcept;
  [[nodiscard]] bool write_device(const Vec3& force_n) noexcept;
  void update_status() noexcept;
  [[nodiscard]] bool answered(int result) noexcept;

  DhdLibrary library_;
  OpenDevice open_;
  StallGuard stall_guard_;
  AutoInit auto_init_;
  std::atomic<bool> cancelled_{false};
  int id_ = -1;
  haptic::Caps caps_{};
  haptic::Identity identity_{};
  bool wrist_ = false;

  mutable std::mutex settings_mutex_;
  int requested_ = 0;
  bool has_auto_init_ = false; ///< the open device can be initialised by auto_init_

  // Used by the servo's thread.
  std::array<int, kMaxStatus> status_{};
  haptic::ForceTimeout timeout_{};
  double written_s_ = -1e9;
  Vec3 last_position_{};
  haptic::WristCommand wrist_command_{};  // for the next write
  std::atomic<bool> wrist_driven_{false}; // driven since the opening; if true, zero is sent too
  haptic::State state_{};                 // of the previous tick
  int until_status_ = 0, until_watchdog_ = 0, error_free_ticks_ = 0;
  bool homed_ = true, limited_ = false, watchdog_due_ = false, has_watchdog_ = false;
  bool initialising_ = false; // the automatic initialisation moves the handle

  // Shared by the servo's thread and others.
  std::atomic<int> force_off_cause_{kNoCause};
  std::atomic<bool> needs_reset_{false}, broken_{false}, reset_requested_{false};
  std::atomic<const char*> error_{nullptr}; ///< a constant text of the library
};

} // namespace tactus::devices::force_dimension

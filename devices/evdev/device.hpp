#pragma once

#include "core/haptic/device/device.hpp"
#include "core/haptic/device/force_timeout.hpp"
#include "devices/evdev/effect.hpp"

#include <array>
#include <atomic>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include <linux/input.h>

namespace tactus::devices::evdev {

/// A joystick or wheel with force feedback through the kernel. Its deflection is the position: x to
/// the right, z towards the user, y from a third axis; full deflection is `reach`. The force has no
/// calibration: `peak` is the force in newtons at full level.
/// Setting an effect may block on the device, so a separate thread does it, at most 250 times a
/// second. That thread ends the force of a stalled servo (force_timeout.hpp); when the program
/// ends, the kernel ends the force. The effect lasts one second and is restarted with every change
/// and four times a second: some drivers ignore an effect of length 0, and some apply a new level
/// only at the next start.
class Device final : public haptic::Backend {
public:
  ~Device() override { close(); }

  [[nodiscard]] std::string open() override;
  void close() noexcept override;
  [[nodiscard]] haptic::Caps caps() const noexcept override { return caps_; }
  [[nodiscard]] bool read(const haptic::Tick& tick, haptic::State& state) noexcept override;
  [[nodiscard]] bool write(const Vec3& force_n) noexcept override;
  /// "device WHICH" (index, /dev/input/eventN or serial), "reach MM" (1..1000), "peak N" (0.1..40),
  /// "wheel 0|1|auto" (force along x alone), "reverse 0|1" (reverses the force, not the position).
  [[nodiscard]] std::string configure(std::span<const std::string> words) override;
  [[nodiscard]] haptic::Identity identity() const override { return identity_; }
  [[nodiscard]] std::string trouble() const override;

private:
  struct Settings {
    std::string device;
    double reach_m = 0.05, peak_n = 3;
    std::optional<bool> wheel{}; ///< if empty, detected from the device's axes
    bool reverse = false;
  };
  struct Axis {
    int code;         ///< ABS_X and so on
    int project_axis; ///< 0 x, 1 y, 2 z
    double sign;
    double centre = 0, half = 0; ///< of the readings; half is 0 without an axis
  };

  [[nodiscard]] std::string open_node(const std::string& node);
  [[nodiscard]] bool read_axes() noexcept;
  void read_buttons();
  void query_all() noexcept;
  void handle_event(const input_event& event) noexcept;
  void set_axis(int code, int value) noexcept;
  void send_forces() noexcept;
  [[nodiscard]] bool looks_like_wheel() const;
  [[nodiscard]] bool upload(const ConstantForce& force) noexcept;
  [[nodiscard]] ConstantForce requested_force() noexcept;
  [[nodiscard]] bool start() noexcept;

  int file_ = -1;
  haptic::Caps caps_{};
  haptic::Identity identity_{};
  std::array<Axis, 3> axes_{{{ABS_X, 0, 1}, {ABS_Y, 2, 1}, {ABS_Z, 1, 1}}};
  std::vector<int> buttons_; ///< key code of each button bit
  haptic::State state_{};
  bool dropping_ = false, two_axes_ = false;

  std::mutex settings_mutex_;
  Settings settings_, active_settings_;

  haptic::TimedMailbox<Vec3> forces_;
  std::thread sender_;
  std::atomic<bool> stop_{false};
  ff_effect effect_{}; ///< last uploaded
  std::atomic<int> read_error_{0}, force_error_{0};
};

} // namespace tactus::devices::evdev

#pragma once

#include "devices/haply/connection.hpp"

namespace tactus::devices::haply {

/// An Inverse3 or Minverse of Haply through Haply's own service, by default on this machine. The
/// service stops the motors when no message arrives; the connection sends zero force when the servo
/// has written none for 50 ms.
class Device final : public haptic::Backend {
public:
  Device();
  ~Device() override { close(); }

  [[nodiscard]] std::string open() override;
  void cancel() noexcept override { connection_.cancel(); }
  void close() noexcept override { connection_.close(); }
  [[nodiscard]] haptic::Caps caps() const noexcept override { return caps_; }
  [[nodiscard]] bool read(const haptic::Tick& tick, haptic::State& state) noexcept override;
  [[nodiscard]] bool write(const Vec3& force_n) noexcept override;
  /// "device WHICH" (index or device_id), "service HOST PORT", "rate HZ" (50..4000),
  /// "peak N" (0.1..20).
  [[nodiscard]] std::string configure(std::span<const std::string> words) override;
  [[nodiscard]] haptic::Identity identity() const override { return identity_; }
  [[nodiscard]] std::string trouble() const override;

private:
  Connection connection_;
  haptic::Caps caps_{};
  haptic::Identity identity_{};
  Vec3 last_position_{}; // m; used by the servo's thread
  std::atomic<bool> calibrated_{true};

  std::mutex settings_mutex_;
  Settings settings_;
  double peak_n_ = 0; ///< limit of the force; 0: the model's own
};

} // namespace tactus::devices::haply

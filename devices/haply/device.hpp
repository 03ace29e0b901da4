#pragma once

#include "devices/haply/connection.hpp"

namespace tactus::devices::haply {

/// An Inverse3 or Minverse through Haply's own service on this machine. The service stops the
/// motors when it hears nothing, so does the connection when the servo says nothing for 50 ms.
class Device final : public haptic::Backend {
public:
  Device();
  ~Device() override { close(); }

  [[nodiscard]] std::string open() override;
  void cancel() noexcept override { connection_.cancel(); }
  void close() noexcept override { connection_.close(); }
  [[nodiscard]] haptic::Caps caps() const noexcept override { return caps_; }
  [[nodiscard]] bool read(const haptic::Tick& tick, haptic::State& state) noexcept override;
  [[nodiscard]] bool write(const haptic::Vec3& force_n) noexcept override;
  /// "device WHICH" (index or device_id), "service HOST PORT", "rate HZ" (50..4000),
  /// "peak N" (0.1..20).
  [[nodiscard]] std::string configure(std::span<const std::string> words) override;
  [[nodiscard]] haptic::Identity identity() const override { return identity_; }
  [[nodiscard]] std::string trouble() const override;

private:
  Connection connection_;
  haptic::Caps caps_{};
  haptic::Identity identity_{};
  haptic::Vec3 last_position_{}; // the servo's
  std::atomic<bool> calibrated_{true};

  std::mutex settings_mutex_;
  Settings settings_;
  double peak_n_ = 0; ///< 0: the model's
};

} // namespace tactus::devices::haply

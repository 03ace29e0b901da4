#pragma once

#include "core/haptic/device/device.hpp"

namespace tactus::haptic_server {

/// A simulated device: the patch sets its position and receives its force.
class PatchDevice final : public haptic::Backend {
public:
  [[nodiscard]] std::string open() override { return {}; }
  void close() noexcept override { force_n_ = {}; }
  [[nodiscard]] haptic::Caps caps() const noexcept override { return caps_; }
  [[nodiscard]] bool read(const haptic::Tick& /*tick*/, haptic::State& state) noexcept override {
    state = state_;
    return true;
  }
  [[nodiscard]] bool write(const Vec3& force_n) noexcept override {
    force_n_ = force_n;
    return true;
  }

  void set_caps(const haptic::Caps& caps) noexcept { caps_ = caps; }
  /// Sets the position in m. Before the first position the force is zero.
  void set_position(const Vec3& position) noexcept {
    state_.position = position;
    state_.flags = haptic::State::kHomed;
  }
  void set_button(int number, bool down) noexcept {
    const std::uint32_t bit = 1u << number;
    state_.buttons = down ? state_.buttons | bit : state_.buttons & ~bit;
  }
  [[nodiscard]] const Vec3& force_n() const noexcept { return force_n_; }

private:
  haptic::Caps caps_{};
  haptic::State state_{.flags = 0};
  Vec3 force_n_{};
};

} // namespace tactus::haptic_server

#pragma once

#include "core/dsp/random.hpp"
#include "core/haptic/chain/zero_order_hold.hpp"
#include "core/haptic/device/device.hpp"
#include "core/haptic/device/hand.hpp"
#include "core/haptic/device/workspace.hpp"

#include <array>
#include <cstddef>

namespace tactus::haptic {

/// A haptic device in software: a handle with mass M and viscous friction B, held by a simulated
/// hand (stiffness K_h, damping B_h, position x_h, velocity v_h):
///   M x'' = F + K_h (x_h - x) + B_h (v_h - v) - B v     on each axis
/// The step is exact for F, x_h and v_h held over a tick (zero_order_hold.hpp). The device advances
/// in read(), by the number of ticks since the last read, so that the same ticks and forces give
/// the same bits. A hard stop (20 kN/m, critically damped) at stop_m outside the workspace pushes
/// the handle back and never pulls.
class SimulatedDevice final : public Backend {
public:
  static constexpr int kMaxLatency_ticks = 8;

  struct Settings {
    double mass_kg = 0.1;
    double viscous_n_s_per_m = 0.5;
    Workspace workspace{};
    bool stops = true;
    double stop_m = 5e-3;    ///< distance from the workspace's faces
    double resolution_m = 0; ///< resolution of the position reading; 0 is exact
    double noise_m = 0;      ///< uniform within plus or minus this
    std::uint64_t seed = 1;  ///< seed of the reading's noise
    int latency_ticks = 0;   ///< delay of the readings, 0..kMaxLatency_ticks
    HandSettings hand{};
  };

  /// The mass must be positive, the other numbers not negative. Position and velocity stay.
  void set(const Settings& settings) noexcept;
  [[nodiscard]] const Settings& settings() const noexcept { return settings_; }

  [[nodiscard]] std::string open() override { return {}; }
  void close() noexcept override { force_ = {}; }
  [[nodiscard]] Caps caps() const noexcept override;
  [[nodiscard]] bool read(const Tick& tick, State& state) noexcept override;
  [[nodiscard]] bool write(const Vec3& force_n) noexcept override;

  void set_path(Path path) noexcept { hand_.set_path(std::move(path)); }
  void set_target(const Vec3& target) noexcept { hand_.set_target(target); }
  void seek(double time_s) noexcept { hand_.seek(time_s); }
  void set_button(int button, bool down) noexcept;
  /// Sets position (m) and velocity (m/s) of the handle.
  void set_state(const Vec3& position, const Vec3& velocity) noexcept;

  /// The exact state, without resolution, noise and latency of the reading.
  [[nodiscard]] const Vec3& position() const noexcept { return position_; }
  [[nodiscard]] const Vec3& velocity() const noexcept { return velocity_; }
  [[nodiscard]] PathPoint hand_point() const noexcept { return hand_.point(); }

private:
  void prepare(double period_s) noexcept;
  void advance() noexcept;
  [[nodiscard]] double measured(double position) noexcept;

  Settings settings_{};
  Hand hand_{};
  double period_s_ = 0;
  MassSpringDamperStep free_step_{}, stop_step_{};
  double stop_damping_ = 0;
  Vec3 position_{}, velocity_{}, force_{};
  std::uint32_t buttons_ = 0;
  std::array<State, kMaxLatency_ticks + 1> readings_{}; ///< ring of the newest readings
  std::size_t reads_ = 0;
  std::uint64_t index_ = 0;
  bool started_ = false;
  Random random_{1};
};

} // namespace tactus::haptic

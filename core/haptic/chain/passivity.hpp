#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>

namespace tactus::haptic {

struct PassivitySettings {
  double period_s = 1e-3;
  double slew_n_per_s = 2000; ///< fastest change of the force
  double tank_j = 5e-3;       ///< largest credit of the observer
  // of the device
  double damping_limit_n_s_per_m = 5; ///< that it renders quietly at 1 kHz
  double position_noise_m = 0;        ///< largest error of one reading
  int latency_ticks = 0;              ///< between a position and the force that answers it
};

/// Time-domain passivity observer and controller after Hannaford & Ryu (IEEE Transactions on
/// Robotics and Automation 18, 2002). docs/phantom.md, "Passivity", has the derivation and the
/// sweep that the bounds were tested with.
///
/// Observer, exact for a force that is held over a tick, with latency L (J):
///   E_n = E_(n-1) - F_(n-1-L) . (x_n - x_(n-1)) + forgiven,   E <= tank
/// E is the energy that the hand has put into the rendered world; negative, the world has given
/// energy away. A debt is forgotten when the handle has rested for kAtRest_s: the device's friction
/// and the hand have then taken it.
///
/// Controller; both parts are bounded, and the slew limit comes after them.
/// 1. While E < 0, a damper b = min((-E - K q^2/2)/(T u^2), c K T, b_device), q an encoder's step.
///    A sampled spring of stiffness K leaks K T (1/2 + L) u^2 watts, so no more damping than a
///    multiple of K T is ever needed: K is measured as the ratio of changes of force to changes of
///    position. u is the velocity along the force as the device reads it,
///    in the direction of the displacement d over the last 2 ms and no faster than d/T.
/// 2. A contact of at most 0.1 s that throws the handle back may release no more than is left: its
///    force is lowered, to nothing at the least, early enough that the slew limit lets it fall in
///    time.
class PassivityController {
public:
  static constexpr double kAtRest_s = 0.05;
  static constexpr int kMaxLatency_ticks = 8;

  /// The handle is at that position (m); until now it felt the force written at the last tick (N).
  void observe(const PassivitySettings& settings, const Vec3& position_m, const Vec3& written_n,
               double allowance_j) noexcept;
  /// The force to write instead of desired_n (N), which contains contact_n, the share of models
  /// that live in the servo. velocity: the device's reading, m/s. Differs from desired_n by no more
  /// than |contact_n| + b_device |velocity|.
  [[nodiscard]] Vec3 limit(const PassivitySettings& settings, const Vec3& desired_n,
                           const Vec3& contact_n, const Vec3& velocity) noexcept;

  [[nodiscard]] double energy_j() const noexcept { return energy_j_; }
  /// Whether the last force was changed.
  [[nodiscard]] bool acted() const noexcept { return acted_; }

private:
  static constexpr std::size_t kHistory = 16;
  static_assert((kHistory & (kHistory - 1)) == 0 && kMaxLatency_ticks < int{kHistory});
  template <class T> static T& at(std::array<T, kHistory>& ring, std::size_t tick) noexcept {
    return ring[tick % kHistory];
  }
  [[nodiscard]] Vec3 displacement(const PassivitySettings& settings) noexcept;
  [[nodiscard]] double stiffness(const PassivitySettings& settings, const Vec3& desired_n) noexcept;
  [[nodiscard]] double release_cut(const PassivitySettings& settings, double contact_n,
                                   double outward, double reading) noexcept;

  std::array<Vec3, kHistory> positions_{}, forces_{};
  std::size_t tick_ = 0;
  double energy_j_ = 0;
  Vec3 rest_position_{};
  double at_rest_s_ = 0;
  Vec3 desired_{}, direction_{}; // the last force, and where the last one that was not zero pointed
  double force_changes_ = 0, position_changes_ = 0; // leaky sums of squares, N^2 and m^2
  double outward_ = 0;                              // m/s, along the contact's force
  double contact_s_ = 0;                            // since it began
  bool started_ = false, acted_ = false;
};

} // namespace tactus::haptic

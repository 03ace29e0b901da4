#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>

namespace tactus::haptic {

/// Settings of the passivity controller, SI.
struct PassivitySettings {
  double period_s = 1e-3;
  double slew_n_per_s = 2000; ///< largest rate of change of the force
  double tank_j = 5e-3;       ///< largest positive energy that the observer stores
  // of the device
  double damping_limit_n_s_per_m = 5; ///< largest damping it renders stably at 1 kHz
  double position_noise_m = 0;        ///< largest error of one reading
  int latency_ticks = 0;              ///< as Caps::latency_ticks
};

/// Passivity observer and controller in the time domain: it removes the energy that a sampled force
/// creates, so that a rendered contact does not start to oscillate. After Hannaford & Ryu, IEEE
/// Transactions on Robotics and Automation 18, 2002; docs/phantom.md, "Passivity", has the
/// derivation and the sweep over walls, rates and encoders that the bounds were tested with.
///
/// Observer, exact for a force that is held over a tick, with latency L ticks (J):
///   E_n = min(E_(n-1) - F_(n-1-L) . (x_n - x_(n-1)) + allowance, tank)
/// E is the energy that the hand has put into the rendered world; E < 0 means that the world has
/// returned more than it got. A negative E is set to zero when the handle has been at rest for
/// kAtRest_s: the device's friction and the hand have then dissipated it.
///
/// Controller, T the period; both parts are bounded, and the slew limit comes after them.
/// 1. While E < 0, a damper
///      b = min((-E - K q^2/2) / (T u^2), c K T, b_device),   c = 3,
///    K is the measured stiffness of the rendered world, the ratio of changes of force to changes
///    of position; q is an encoder's step; u is the velocity reading along the force, where its
///    sign agrees with the displacement d over the last 2 ms, and no faster than d/T. A sampled
///    spring of stiffness K creates the power K T (1/2 + L) u^2, so that a multiple of K T
///    suffices.
/// 2. A contact of at most 0.1 s that throws the handle back may release no more than E: its force
///    is reduced, at most to zero, early enough for the slew limit.
class PassivityController {
public:
  static constexpr double kAtRest_s = 0.05;
  static constexpr int kMaxLatency_ticks = 8;

  /// Updates the observer. position_m: of the handle now; written_n: the force (N) that was written
  /// in the last tick; allowance_j: energy to add, see chain.cpp.
  void observe(const PassivitySettings& settings, const Vec3& position_m, const Vec3& written_n,
               double allowance_j) noexcept;
  /// The force (N) to write instead of desired_n. contact_n: the part of desired_n from models
  /// inside the servo; velocity: the device's reading, m/s. The result differs from desired_n by no
  /// more than |contact_n| + b_device |velocity|.
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
  Vec3 desired_{}, direction_{}; // the last force; direction of the last one that was not zero
  double force_changes_ = 0, position_changes_ = 0; // leaky sums of squares, N^2 and m^2
  double outward_ = 0;                              // m/s, along the contact's force
  double contact_s_ = 0;                            // since it began
  bool started_ = false, acted_ = false;
};

} // namespace tactus::haptic

#pragma once

#include "core/dsp/random.hpp"
#include "core/haptic/chain/zero_order_hold.hpp"
#include "core/haptic/device/path.hpp"

#include <array>
#include <cstdint>

/// A model of the hand that holds the simulated device: docs/theory/simulated_device.md.
namespace tactus::haptic {

/// Band-limited Gaussian noise: an oscillator driven by white noise,
///   x'' + 2 zeta w x' + w^2 x = white noise,   scaled so that the RMS of x is s.
/// The step is exact: with the stationary covariance P = diag(s^2, s^2 w^2) and the transition
/// matrix Phi, the noise of one step has the covariance P - Phi P Phi^T. RMS and spectrum therefore
/// do not depend on the period of the ticks.
class NoiseOscillator {
public:
  /// The half-power width of the spectrum of x is about 2 damping_ratio frequency_hz.
  void set(double frequency_hz, double damping_ratio, double rms, double period_s) noexcept;
  /// Sets the state to a random one of the stationary process.
  void start(Random& random) noexcept;
  void advance(Random& random) noexcept;
  /// x
  [[nodiscard]] double value() const noexcept { return x_; }
  /// x'
  [[nodiscard]] double rate() const noexcept { return v_; }

private:
  MassSpringDamperStep step_{};
  double rms_x_ = 0, rms_v_ = 0;
  double noise_xx_ = 0, noise_vx_ = 0, noise_vv_ = 0; // Cholesky factor
  double x_ = 0, v_ = 0;
};

struct HandSettings {
  enum class Hold {
    kFree,   ///< nobody holds the handle
    kRigid,  ///< the handle follows the path exactly, whatever the force
    kSpring, ///< a spring and a damper between the handle and the path
    kPerson, ///< as kSpring, with tremor and wander, and yielding to a lasting force
  };
  Hold hold = Hold::kSpring;
  double stiffness_n_per_m = 200;
  double damping_n_s_per_m = 2;

  // kPerson
  double tremor_m = 1e-4;      ///< RMS on each axis
  double tremor_hz = 10;       ///< middle of 8..12 Hz
  double tremor_damping = 0.2; ///< zeta; the half-power width is then 4 Hz
  double wander_m = 1e-3;      ///< RMS on each axis
  double wander_hz = 0.2;
  double yield_s = 1; ///< a lasting force F moves the hand's target at the velocity F/(K yield_s)
  std::uint64_t seed = 1;
};

/// The point that the hand pulls the handle to, tick by tick: a path or a target, plus tremor,
/// wander and yielding for kPerson.
class Hand {
public:
  void set(const HandSettings& settings, double period_s) noexcept;
  [[nodiscard]] const HandSettings& settings() const noexcept { return settings_; }

  /// Follows a path from its time 0 on.
  void set_path(Path path) noexcept;
  /// Follows a moving target through a critically damped second-order low-pass of 20 ms.
  void set_target(const Vec3& target) noexcept;
  /// Jumps to this time of the path.
  void seek(double time_s) noexcept;

  /// The hand's position and velocity now.
  [[nodiscard]] PathPoint point() const noexcept;
  /// Advances by one tick; `handle` is the position of the device's handle, m.
  void advance(const Vec3& handle) noexcept;

private:
  [[nodiscard]] PathPoint intended() const noexcept;

  HandSettings settings_{};
  double period_s_ = 1e-3;
  Path path_ = LinePath{};
  double origin_s_ = 0; // path time when ticks_ was 0
  std::uint64_t ticks_ = 0;
  bool has_target_ = false;
  Vec3 target_{};
  PathPoint follower_state_{};
  MassSpringDamperStep follower_{};
  Vec3 yield_displacement_{}, yield_velocity_{};
  std::array<NoiseOscillator, 3> tremor_{}, wander_{};
  Random random_{1};
};

} // namespace tactus::haptic

#pragma once

#include "core/dsp/random.hpp"
#include "core/haptic/chain/zero_order_hold.hpp"
#include "core/haptic/device/path.hpp"

#include <array>
#include <cstdint>

/// The hand that holds the simulated device. docs/phantom.md, "The hand".
namespace tactus::haptic {

/// A noise with a preferred frequency: x'' + 2 z w x' + w^2 x = white noise, scaled to a given RMS
/// of x. Stepped exactly: with the stationary covariance P = diag(s^2, s^2 w^2), the noise of one
/// step has covariance P - Phi P Phi^T, so RMS and spectrum do not depend on the tick.
class NoiseOscillator {
public:
  /// Half-power width of the spectrum of x is about 2 damping_ratio frequency_hz.
  void set(double frequency_hz, double damping_ratio, double rms, double period_s) noexcept;
  /// Draws a value of the stationary process.
  void start(Random& random) noexcept;
  void advance(Random& random) noexcept;
  [[nodiscard]] double value() const noexcept { return x_; }
  [[nodiscard]] double rate() const noexcept { return v_; }

private:
  MassSpringDamperStep step_{};
  double rms_x_ = 0, rms_v_ = 0;
  double noise_xx_ = 0, noise_vx_ = 0, noise_vv_ = 0; // Cholesky factor
  double x_ = 0, v_ = 0;
};

struct HandSettings {
  enum class Hold {
    kFree,   ///< nobody: the handle moves by itself
    kRigid,  ///< the handle is where the path is, whatever the force
    kSpring, ///< a spring and a damper between the handle and the path
    kPerson, ///< the same with tremor and wander, and yielding to a lasting force
  };
  Hold hold = Hold::kSpring;
  double stiffness_n_per_m = 200;
  double damping_n_s_per_m = 2;

  // kPerson
  double tremor_m = 1e-4;      ///< RMS an axis
  double tremor_hz = 10;       ///< middle of 8..12 Hz
  double tremor_damping = 0.2; ///< ratio; half-power width 4 Hz
  double wander_m = 1e-3;      ///< RMS an axis
  double wander_hz = 0.2;
  double yield_s = 1; ///< a lasting force F moves the intention at F/(K yield_s)
  std::uint64_t seed = 1;
};

class Hand {
public:
  void set(const HandSettings& settings, double period_s) noexcept;
  [[nodiscard]] const HandSettings& settings() const noexcept { return settings_; }

  /// Follows a path from its time 0 on.
  void set_path(Path path) noexcept;
  /// Follows a point that a patch moves, through a critically damped follower of 20 ms.
  void set_target(const Vec3& target) noexcept;
  void seek(double time_s) noexcept;

  /// Where the hand is now. Pure.
  [[nodiscard]] PathPoint point() const noexcept;
  /// One tick further, the handle being at that position.
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

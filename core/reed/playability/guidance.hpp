#pragma once

#include "core/reed/playability/gradient_plane.hpp"
#include "core/reed/playability/guidance_field.hpp"

namespace tactus::reed {

/// A force on the hand along y and z, N.
struct PlaneForce {
  double y = 0, z = 0;
};

/// Smooths a force: on each axis a one-pole low-pass and a slew limit.
class ForceSmoother {
public:
  /// time_constant_s >= 0, slew_n_per_s > 0.
  void set(double time_constant_s, double slew_n_per_s) noexcept;
  void reset(const PlaneForce& force = {}) noexcept { force_ = force; }
  /// The force after a time elapsed_s > 0; a target that is not finite counts as no force.
  PlaneForce advance(const PlaneForce& target, double elapsed_s) noexcept;

private:
  double time_constant_s_ = 30e-3, slew_n_per_s_ = 20;
  double elapsed_s_ = 0, smoothing_gain_ = 0; // gain of the low-pass for a step of elapsed_s_
  PlaneForce force_{};
};

/// The force law of the five-reed patch, towards higher playability: on each axis
///   F = F_max tanh(gain g/F_max),
/// gain_n in N for a gradient g of 1 per side of the plane, ceiling_n = F_max in N.
[[nodiscard]] PlaneForce gradient_force(const Gradient& gradient, double gain_n,
                                        double ceiling_n) noexcept;

/// Haptic guidance: pulls the hand to the region where the instrument plays and exerts no force
/// inside it, except for a soft wall at the border.
///   F = -F_max (s grad D + b v),  s = max(w, q u),
///   w = clip(1 + D'/m, 0, 1),     D' = D + t_a v . grad D,
///   u = clip(2 + D/m, 0, 1),      q = clip((0.4 - f_p)/0.2, 0, 1),
///   b = (t_a/m) (1 - |grad D|^2) min(clip(1 + D/m, 0, 1), clip(1 - 2D/m, 0, 1)),
/// D is the signed distance to the playing region (GuidanceField), v the hand's velocity in sides
/// of the plane per second, f_p the measured playability. |F| <= F_max.
///
/// - w: full pull outside the region at any distance, and a wall of width m inside its border. The
///   prediction by t_a is damping that compensates the delay of the loop.
/// - q u: pulls on to the depth 2 m while a note that should sound does not (f_p < 0.4).
/// - b: brake in the middle of a region narrower than 2 m. There grad D changes sign, so that the
///   damping of the two walls vanishes.
///
/// A ForceSmoother follows. Its slew limit must let the wall rise faster than a hand crosses a
/// narrow region: at 20 N/s the hand oscillates. The stiffness of the wall is F_max/m, 400 N/m for
/// 2 N on a side of 100 mm. The loop is stable if t_a exceeds its delay (7 ms in a patch with
/// blocks of 64 at 48 kHz).
class Guidance {
public:
  struct Settings {
    double ceiling_n = 2;         ///< F_max
    double margin = 0.05;         ///< m, of the plane's side
    double anticipation_s = 0.03; ///< t_a
    double velocity_s = 5e-3;     ///< time constant of the estimate of v
    double smoothing_s = 2e-3;
    double slew_n_per_s = 200;
  };
  /// Height of a GrowthMap at which a note counts as playing: g = 8 1/s.
  static constexpr double kQuickGrowth = 8.0 / (8.0 + 50.0);

  void set(const Settings& settings) noexcept;
  /// Discards the hand's velocity; the force continues from `force`.
  void reset(const PlaneForce& force = {}) noexcept;
  /// The force for a hand at (y, z) in [0, 1], elapsed_s > 0 s after the last call, with the f_p
  /// measured there. A position that is not finite counts as fade().
  PlaneForce advance(const GuidanceField& field, double y, double z, double playability,
                     double elapsed_s) noexcept;
  /// Lets the force decay to 0 while there is no field or no hand; discards the hand's velocity.
  PlaneForce fade(double elapsed_s) noexcept;

private:
  Settings settings_{};
  ForceSmoother smoother_;
  double y_ = 0, z_ = 0, velocity_y_ = 0, velocity_z_ = 0;
  bool started_ = false;
};

} // namespace tactus::reed

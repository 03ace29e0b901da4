#pragma once

#include "core/reed/playability/gradient_plane.hpp"
#include "core/reed/playability/guidance_field.hpp"

namespace tactus::reed {

/// A force on the hand along y and z, N.
struct PlaneForce {
  double y = 0, z = 0;
};

/// What keeps a force off sudden changes: on each axis a one-pole low-pass, and a limit on the
/// rate.
class ForceSmoother {
public:
  /// time_constant_s >= 0, slew_n_per_s > 0.
  void set(double time_constant_s, double slew_n_per_s) noexcept;
  void reset(const PlaneForce& force = {}) noexcept { force_ = force; }
  /// The force elapsed_s > 0 later; what is not finite counts as no force.
  PlaneForce advance(const PlaneForce& target, double elapsed_s) noexcept;

private:
  double time_constant_s_ = 30e-3, slew_n_per_s_ = 20;
  double elapsed_s_ = 0, smoothing_gain_ = 0; // what the last step of this length covers of the way
  PlaneForce force_{};
};

/// The force law of the five-reed patch, towards greater playability: on each axis
/// F = F_max tanh(gain g/F_max), gain in N for a gradient of 1 per side of the plane.
[[nodiscard]] PlaneForce gradient_force(const Gradient& gradient, double gain_n,
                                        double ceiling_n) noexcept;

/// Leads a hand to where the instrument plays and leaves it alone there:
///   F = -F_max (s grad D + b v),  s = max(w, q u),
///   w = clip(1 + D'/m, 0, 1),     D' = D + t_a v . grad D,
///   u = clip(2 + D/m, 0, 1),      q = clip((0.4 - f_p)/0.2, 0, 1),
///   b = (t_a/m) (1 - |grad D|^2) min(clip(1 + D/m, 0, 1), clip(1 - 2D/m, 0, 1)),
/// D the GuidanceField at the hand, v the hand's velocity in sides of the plane a second, f_p what
/// is measured. w is the pull from silence, as strong as allowed however far the next note is, and
/// the wall inside the border, which a hand on its way out meets t_a earlier and one on its way in
/// later: damping that makes up for the delay of the loop. q u goes on pulling, to the depth 2 m,
/// while a note that should sound does not. Deeper inside a sounding region there is no force.
/// b brakes in the middle of a note narrower than 2 m: there grad D turns over, and with it goes
/// the damping of the two walls that meet. |F| is at most F_max.
///
/// Then a ForceSmoother, whose slew lets the wall rise as fast as a hand comes: at 20 N/s it takes
/// longer than a hand needs to cross a narrow note, which is then thrown to and fro. The wall is as
/// stiff as F_max/m: 400 N/m for 2 N on a side of 100 mm. Steady where t_a exceeds the loop's delay
/// (7 ms in a patch with blocks of 64 at 48 kHz).
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
  /// Of a GrowthMap's height: a note grows at 8 1/s or faster.
  static constexpr double kQuickGrowth = 8.0 / (8.0 + 50.0);

  void set(const Settings& settings) noexcept;
  /// Forgets where the hand was; the force goes on from the given one.
  void reset(const PlaneForce& force = {}) noexcept;
  /// The force for a hand at (y, z) in [0, 1], elapsed_s > 0 after the last; f_p of the reed there.
  /// What is not finite gives no force and is forgotten.
  PlaneForce advance(const GuidanceField& field, double y, double z, double playability,
                     double elapsed_s) noexcept;
  /// As advance() while nothing is known: the force goes to 0 and the hand is forgotten.
  PlaneForce fade(double elapsed_s) noexcept;

private:
  Settings settings_{};
  ForceSmoother smoother_;
  double y_ = 0, z_ = 0, velocity_y_ = 0, velocity_z_ = 0;
  bool started_ = false;
};

} // namespace tactus::reed

#pragma once

#include "core/footstep/track.hpp"

namespace tactus::footstep {

/// Styles of walking.
enum class Style { kWalk, kRun, kSneak, kUpstairs, kDownstairs };

/// Relates a walker's weight to the mass, m/s^2.
inline constexpr double kGravity = 9.81;

/// A walking person.
struct Walker {
  double speed_m_per_s = 1.4; ///< on level ground; stairs and sneaking reduce it
  double weight_n = 700;
  double shoe = 0.4; ///< hardness of sole and heel: 0 barefoot or soft, 1 hard
  Style style = Style::kWalk;
};

/// The landing of one part of the sole: half a sine of force, kImpactTime long, stops the effective
/// mass behind it. The impulse of the force is mass * speed.
struct Landing {
  static constexpr double kImpactTime = 0.03; ///< s, half a period of a heel pad loaded with that
                                              ///< mass
  double at = 0;                              ///< time, as a share of the stance
  double speed_m_per_s = 0;                   ///< downwards
  double mass = 0;                            ///< effective mass, as a share of the body's mass
  /// Largest force in body weights.
  [[nodiscard]] double peak(double speed) const noexcept;
};

/// Vertical ground reaction force on one foot of a steady walker over its stance, x = time / stance
/// in 0..1; the share of it under the heel; and the landings.
///
/// The mean force over the stance is weight / (2 duty), duty = stance / stride: in a steady gait
/// each foot carries half of the weight on average.
/// Walking and stairs: two peaks and a valley, joined by half cosines. The outer flanks are a
/// mixture of sine and squared sine, chosen so that peaks and mean are both exact. Walking uses
/// published values at 0.8, 1.1, 1.4 and 1.8 m/s, interpolated linearly.
/// Running: half a sine, no double support.
/// Sneaking: both feet together carry exactly the weight at any time, so the body does not
/// accelerate.
/// Numbers and sources: docs/theory/footstep.md.
class GroundReaction {
public:
  GroundReaction() { set({}); }
  /// Speed is clamped to 0.3..2.5 m/s, or to 1.5..8 m/s for running. NaN counts as the default.
  void set(const Walker& walker) noexcept;

  [[nodiscard]] double weight_n() const noexcept { return weight_n_; }
  [[nodiscard]] double stance_s() const noexcept { return stance_s_; }
  [[nodiscard]] double stride_s() const noexcept { return stride_s_; }
  [[nodiscard]] double duty() const noexcept { return stance_s_ / stride_s_; }
  /// Time in the air between two steps of a runner, s; else 0.
  [[nodiscard]] double flight_s() const noexcept;

  /// Force in N at x in 0..1; 0 outside.
  [[nodiscard]] double force(double x) const noexcept;
  /// Share of force(x) (without landings) under the heel; the rest is under the ball.
  [[nodiscard]] double heel_share(double x) const noexcept { return share_.at(x); }

  /// The load without landings over x, in body weights; then its parts before and after the middle
  /// of the stance. At the middle the body neither rises nor falls, and the load is at its valley
  /// (walking), at its peak (running) or constant (sneaking).
  [[nodiscard]] const Track& load() const noexcept { return load_; }
  [[nodiscard]] const Track& first_half() const noexcept { return first_half_; }
  [[nodiscard]] const Track& second_half() const noexcept { return second_half_; }
  [[nodiscard]] double middle() const noexcept { return first_half_.duration_s(); }

  [[nodiscard]] bool ball_first() const noexcept { return ball_.at < heel_.at; }
  [[nodiscard]] const Landing& heel() const noexcept { return heel_; }
  [[nodiscard]] const Landing& ball() const noexcept { return ball_; }
  [[nodiscard]] double heel_up_at() const noexcept { return heel_up_at_; }
  [[nodiscard]] double release_at() const noexcept { return release_at_; }
  [[nodiscard]] double max_heel_share() const noexcept { return max_heel_share_; }
  /// Duration of the sin^2 pulse that a hard heel adds, s: the width of a Gaussian of deviation 7
  /// ms.
  static constexpr double kTransientTime = 0.033;
  /// Peak of this pulse, body weights.
  [[nodiscard]] double transient() const noexcept { return transient_; }
  /// Sliding speed of the first contact before it sticks, m/s.
  [[nodiscard]] double contact_slip() const noexcept { return contact_slip_; }

private:
  struct Shape;
  void set_walk(const Shape& shape) noexcept;
  void set_run(double speed, double shoe) noexcept;
  void set_sneak(double speed) noexcept;
  void set_times(double steps_a_minute, double duty) noexcept;
  void set_share() noexcept;
  [[nodiscard]] double landing_mean() const noexcept;

  double weight_n_ = 700, stance_s_ = 0.7, stride_s_ = 1.1;
  Style style_ = Style::kWalk;
  Track load_, first_half_, second_half_, share_; // functions of x
  Landing heel_, ball_;
  double heel_up_at_ = 0.62, release_at_ = 0.66, max_heel_share_ = 1;
  double transient_ = 0, contact_slip_ = 0;
};

/// Share of the load under the heel over time, from the first contact. If the heel lands first, it
/// carries the whole load until the ball lands; then the heel's share falls to 0 at `release_at`.
/// If the ball lands first, the share is 0 until the heel lands. All times have the same unit,
/// whichever it is.
[[nodiscard]] Track heel_share_track(double heel_at, double ball_at, double release_at,
                                     double highest) noexcept;

} // namespace tactus::footstep

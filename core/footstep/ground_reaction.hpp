#pragma once

#include "core/footstep/track.hpp"

namespace tactus::footstep {

/// Ways of walking.
enum class Style { kWalk, kRun, kSneak, kUpstairs, kDownstairs };
inline constexpr int kStyles = 5;

/// Who walks, and how.
struct Walker {
  double speed_m_per_s = 1.4; ///< on level ground; on stairs and sneaking people slow down
  double weight_n = 700;
  double shoe = 0.4; ///< hardness of sole and heel: 0 barefoot or soft, 1 hard
  Style style = Style::kWalk;
};

/// How one part of the sole meets the ground: the body's mass behind it is stopped by half a sine
/// of force, kImpactTime long, whose impulse is mass * speed.
struct Landing {
  static constexpr double kImpactTime = 0.03; ///< s, half a period of a heel pad under that mass
  double at = 0;                              ///< part of the stance
  double speed_m_per_s = 0;                   ///< downwards
  double mass = 0;                            ///< effective, part of the body's
  /// Highest force in body weights.
  [[nodiscard]] double peak(double speed) const noexcept;
};

/// Vertical force of the ground on one foot over its stance, x = time / stance in 0..1, its share
/// under the heel, and the landings, for a walker who keeps on. The mean over the stance is
/// weight / (2 duty), the impulse that any steady gait needs: each foot carries half of it.
///
/// Walking and stairs: two peaks and a valley, joined by half cosines; the flanks outside are a
/// mixture of sine and squared sine, so chosen that peaks and mean are both exact. Walking has
/// published values at 0.8, 1.1, 1.4 and 1.8 m/s, straight lines between.
/// Running: half a sine, no double support.
/// Sneaking: what one foot loses the other takes, so slowly that the body does not accelerate: the
/// sum of both feet is the weight at any time.
/// docs/footstep.md has the numbers and their sources.
class GroundReaction {
public:
  GroundReaction() { set({}); }
  /// Speed is held within 0.3..2.5 m/s; running within 1.5..8 m/s.
  void set(const Walker& walker) noexcept;

  [[nodiscard]] double weight_n() const noexcept { return weight_n_; }
  [[nodiscard]] double stance_s() const noexcept { return stance_s_; }
  [[nodiscard]] double stride_s() const noexcept { return stride_s_; }
  [[nodiscard]] double duty() const noexcept { return stance_s_ / stride_s_; }
  /// In the air between two steps of a runner; 0 where there is none.
  [[nodiscard]] double flight_s() const noexcept;

  /// Force in N at x in 0..1; 0 outside.
  [[nodiscard]] double force(double x) const noexcept;
  /// Part of that force (without landings) under the heel; the rest is under the ball.
  [[nodiscard]] double heel_share(double x) const noexcept { return share_.at(x); }

  /// The load without landings, body weights over x; and the same up to and from the middle of the
  /// stance, where it is least (walking) or level (sneaking) and the body neither rises nor falls.
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
  /// sin^2 of kTransientTime that a hard heel adds, weights.
  static constexpr double kTransientTime = 0.033; ///< s, as wide as a bell curve of 7 ms deviation
  [[nodiscard]] double transient() const noexcept { return transient_; }
  /// Speed of the first contact along the ground before it holds, m/s.
  [[nodiscard]] double contact_slip() const noexcept { return contact_slip_; }

private:
  struct Shape;
  void set_walk(const Shape& shape) noexcept;
  void set_run() noexcept;
  void set_sneak() noexcept;
  void set_share() noexcept;
  [[nodiscard]] double landing_mean() const noexcept;

  double weight_n_ = 700, stance_s_ = 0.7, stride_s_ = 1.1;
  Style style_ = Style::kWalk;
  Track load_, first_half_, second_half_, share_; // over x
  Landing heel_, ball_;
  double heel_up_at_ = 0.62, release_at_ = 0.66, max_heel_share_ = 1;
  double transient_ = 0, contact_slip_ = 0;
};

/// The heel's share from the first contact on: with the heel first all of it until the ball lands,
/// then falling to nothing; with the ball first none until the heel lands. Times in any one unit.
[[nodiscard]] Track heel_share_track(double heel_at, double ball_at, double release_at,
                                     double highest) noexcept;

} // namespace tactus::footstep

#pragma once

#include "core/footstep/footfall.hpp"
#include "core/footstep/ground_reaction.hpp"

#include <array>

namespace tactus::footstep {

/// What feet do on the ground, as footfalls to be played. Equations, numbers and sources:
/// docs/footstep.md, "Ways of walking". Loads in N from a weight in N.

/// How one step differs from the walker's mean: factors.
struct StepVariation {
  double time = 1, force = 1, heel_speed = 1, ball_speed = 1, roll = 1;
};

/// A step of a walker who keeps on.
[[nodiscard]] Footfall stance(const GroundReaction& reaction, const StepVariation& vary) noexcept;

/// Turns a step into a pivot: once the heel is up the ball turns by that angle (radians) under the
/// load, and slides over the ground by angle times 2/3 of its radius (the mean over a disc).
void pivot(Footfall& step, const GroundReaction& reaction, double angle_rad) noexcept;

/// Two footfalls that begin together, and when what follows may begin.
struct FootfallPair {
  std::array<Footfall, 2> feet;
  double next_start_s = 0;
};

/// From standing to walking: feet[0] takes over the weight and pushes off, feet[1] leaves the
/// ground; it lands after `next_start_s`. The body's vertical momentum is zero while standing and
/// at the middle of a stance: the shift of weight leaves it so. A runner pushes off to the first
/// flight.
[[nodiscard]] FootfallPair set_off(const GroundReaction& reaction) noexcept;

/// The reverse of that: feet[0] lands with the last step and stays; feet[1] is to land beside it
/// `next_start_s` later and stays as well. Both then carry half of the weight.
[[nodiscard]] FootfallPair halt(const GroundReaction& reaction) noexcept;

/// A foot that is put down gently and stands with half of the weight.
[[nodiscard]] Footfall stand(double weight_n) noexcept;
/// A standing foot that leaves the ground at once.
[[nodiscard]] Footfall lift(double load_n) noexcept;

/// A jump on both feet from standing to standing, the same for each: crouch, push-off,
/// 2 sqrt(2 h / g) in the air, landing with sqrt(2 g h) on the ball, then the heel. The first
/// lasts until take-off, the second begins at the landing, `next_start_s` after the first's begin.
struct Jump {
  Footfall push_off, landing;
  double next_start_s = 0;
};
inline constexpr double kMinJump = 0.01, kMaxJump = 1.0; ///< m
[[nodiscard]] Jump jump(double height_m, double weight_n) noexcept;

/// The ball of a swinging foot that strikes the ground and slides until it is free again: `length`
/// m, from the speed at which the foot swings over the ground to nothing.
[[nodiscard]] Footfall scuff(double length_m, double speed_m_per_s, double weight_n) noexcept;

inline constexpr double kMinDrag = 0.01, kMaxDrag = 20;          ///< m
inline constexpr double kMinDragSpeed = 0.02, kMaxDragSpeed = 5; ///< m/s
/// A foot that slides along the ground by that length at that speed under 30 % of the weight. From
/// standing feet[0] slides and feet[1] carries the rest; both stand before and after.
inline constexpr double kDragLoad = 0.3;
/// The speed at which a drag takes that long from first to last touch.
[[nodiscard]] double drag_speed(double length_m, double total_s) noexcept;
[[nodiscard]] Footfall drag(double length_m, double speed_m_per_s, double weight_n) noexcept;
[[nodiscard]] FootfallPair standing_drag(double length_m, double speed_m_per_s,
                                         double weight_n) noexcept;

} // namespace tactus::footstep

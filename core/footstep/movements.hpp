#pragma once

#include "core/footstep/footfall.hpp"
#include "core/footstep/ground_reaction.hpp"

#include <array>

namespace tactus::footstep {

/// Makes the footfalls of steps, halts, jumps, scuffs and drags. Loads in N, from a weight in N.
/// Equations, numbers and sources: docs/theory/footstep.md, "Movements".

/// Factors by which one step differs from the walker's mean.
struct StepVariation {
  double time = 1, force = 1, heel_speed = 1, ball_speed = 1, roll = 1;
};

/// A step of steady walking.
[[nodiscard]] Footfall stance(const GroundReaction& reaction, const StepVariation& vary) noexcept;

/// Turns a step into a pivot: once the heel is up, the ball turns by this angle, radians, under the
/// load. It slides over the ground by angle times 2/3 of its radius, the mean over a disc.
void pivot(Footfall& step, const GroundReaction& reaction, double angle_rad) noexcept;

/// Two footfalls that begin together, and the time at which the next movement may begin.
struct FootfallPair {
  std::array<Footfall, 2> feet;
  double next_start_s = 0;
};

/// From standing to walking: feet[0] takes over the weight and pushes off; feet[1] leaves the
/// ground and lands after `next_start_s`. The body's vertical momentum is zero while standing and
/// at the middle of a stance, and the shift of weight keeps it zero. A runner pushes off into the
/// first flight.
[[nodiscard]] FootfallPair set_off(const GroundReaction& reaction) noexcept;

/// From walking to standing: feet[0] lands with the last step and stays; feet[1] has to land beside
/// it `next_start_s` later and stays too. Then each carries half of the weight.
[[nodiscard]] FootfallPair halt(const GroundReaction& reaction) noexcept;

/// A foot that is put down gently and then stands under half of the weight.
[[nodiscard]] Footfall stand(double weight_n) noexcept;
/// A standing foot that leaves the ground at once.
[[nodiscard]] Footfall lift(double load_n) noexcept;

/// A jump on both feet from standing to standing, equal for both feet: crouch, push-off, a flight
/// of 2 sqrt(2 h / g), landing at sqrt(2 g h) on the ball, then on the heel. `push_off` lasts until
/// take-off; `landing` begins `next_start_s` after the beginning of `push_off`.
struct Jump {
  Footfall push_off, landing;
  double next_start_s = 0;
};
inline constexpr double kMinJump = 0.01, kMaxJump = 1.0; ///< m
[[nodiscard]] Jump jump(double height_m, double weight_n) noexcept;

/// The ball of a swinging foot strikes the ground and slides by length_m, while its speed falls
/// from speed_m_per_s to 0.
[[nodiscard]] Footfall scuff(double length_m, double speed_m_per_s, double weight_n) noexcept;

inline constexpr double kMinDrag = 0.01, kMaxDrag = 20;          ///< m
inline constexpr double kMinDragSpeed = 0.02, kMaxDragSpeed = 5; ///< m/s
inline constexpr double kDragLoad = 0.3;                         ///< share of the weight
/// Speed at which a drag takes total_s from first to last touch, m/s.
[[nodiscard]] double drag_speed(double length_m, double total_s) noexcept;
/// A foot slides along the ground by this length at this speed, under kDragLoad of the weight.
[[nodiscard]] Footfall drag(double length_m, double speed_m_per_s, double weight_n) noexcept;
/// A drag from standing: feet[0] slides and feet[1] carries the rest of the weight; both feet stand
/// before and after.
[[nodiscard]] FootfallPair standing_drag(double length_m, double speed_m_per_s,
                                         double weight_n) noexcept;

} // namespace tactus::footstep

#pragma once

#include <array>

namespace tactus::footstep {

/// Phases of a step.
enum class Phase { kHeelDown, kBallDown, kHeelUp, kToeOff };

/// What one foot does in one sample, whoever says it: gait, sensors or a hand.
struct SoleState {
  double heel_n = 0, ball_n = 0;         ///< forces, N
  double heel_slope = 0, ball_slope = 0; ///< their derivatives, N/s
  double heel_landing = 0,
         ball_landing = 0;               ///< speed (m/s) in the sample in which it lands, else 0
  double heel_slip = 0, ball_slip = 0;   ///< speed of the sole along the ground, m/s
  bool heel_up = false, toe_off = false; ///< in the sample in which it happens
};

} // namespace tactus::footstep

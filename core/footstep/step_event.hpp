#pragma once

#include <array>

namespace tactus::footstep {

/// Phases of a step.
enum class Phase { kHeelDown, kBallDown, kHeelUp, kToeOff };

/// Motion and forces of one sole in one sample, from Gait, SoleSensor or messages.
struct SoleState {
  double heel_n = 0, ball_n = 0;         ///< forces, N
  double heel_slope = 0, ball_slope = 0; ///< their derivatives, N/s
  double heel_landing = 0,
         ball_landing = 0;               ///< landing speed, m/s, in the sample of landing; else 0
  double heel_slip = 0, ball_slip = 0;   ///< sliding speed along the ground, m/s
  bool heel_up = false, toe_off = false; ///< true in the sample of the event
};

} // namespace tactus::footstep

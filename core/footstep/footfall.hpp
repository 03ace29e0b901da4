#pragma once

#include "core/footstep/ground_reaction.hpp"
#include "core/footstep/step_event.hpp"
#include "core/footstep/track.hpp"

#include <array>
#include <cstddef>

namespace tactus::footstep {

/// One contact of one foot with the ground, from first touch (or from standing) to take-off: load,
/// the heel's share of it, the impacts of landing, and sliding. Made by the functions of
/// movements.hpp; advance() plays it sample by sample.
class Footfall {
public:
  /// Landing of a part of the sole: half a sine of force over Landing::kImpactTime, and a pulse
  /// sin^2 over bell_s.
  struct Impact {
    bool heel = true;
    double at_s = 0;
    double speed_m_per_s = 0; ///< 0: no landing
    double peak_n = 0, bell_n = 0, bell_s = GroundReaction::kTransientTime;
    [[nodiscard]] double impulse() const noexcept;             ///< N s
    [[nodiscard]] double force(double since_s) const noexcept; ///< N, at at_s + since_s
  };

  Track load{0};                    ///< N, without impacts
  Track heel_share{1};              ///< heel's share of the load
  Track heel_slip{0}, ball_slip{0}; ///< m/s along the ground, 0 at the end
  std::array<Impact, 2> impacts{};
  double heel_up_s = -1;      ///< time at which the heel lifts; negative: with the rest of the foot
  bool unloads_other = false; ///< its load is taken from the other foot, which carries the body
  bool ends_standing = false; ///< keeps its last load; else the foot leaves the ground at the end

  /// To be called once before advance(). An initial load is not reported as a jump of the force.
  void start() noexcept;
  /// Advances by step_s and adds forces, landings and slip to `sole`.
  void advance(double step_s, SoleState& sole) noexcept;
  [[nodiscard]] bool active() const noexcept { return active_; }
  /// True while the foot stands under a constant load.
  [[nodiscard]] bool at_rest() const noexcept {
    return active_ && ends_standing && time_s_ >= load.duration_s();
  }
  [[nodiscard]] double force_n() const noexcept { return heel_n_ + ball_n_; }
  [[nodiscard]] double time_s() const noexcept { return time_s_; }
  void end() noexcept { active_ = false; }

private:
  void land(SoleState& sole) noexcept;

  bool active_ = false, heel_is_up_ = false;
  std::array<bool, 2> landed_{};
  double time_s_ = 0, heel_n_ = 0, ball_n_ = 0;
  double impacts_end_s_ = 0; ///< end of the last impact
  std::size_t load_piece_ = 0, share_piece_ = 0, heel_slip_piece_ = 0, ball_slip_piece_ = 0;
};

} // namespace tactus::footstep

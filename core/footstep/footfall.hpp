#pragma once

#include "core/footstep/ground_reaction.hpp"
#include "core/footstep/step_event.hpp"
#include "core/footstep/track.hpp"

#include <array>
#include <cstddef>

namespace tactus::footstep {

/// One time of one foot on the ground, from its first touch (or from standing) to its last: load,
/// the heel's share of it, impacts where a part lands, and sliding. Filled by movements.hpp, played
/// a sample at a time.
class Footfall {
public:
  /// A part of the sole that lands: half a sine of force over Landing::kImpactTime, and a bell,
  /// sin^2 over bell_s.
  struct Impact {
    bool heel = true;
    double at_s = 0;
    double speed_m_per_s = 0; ///< 0: nothing lands
    double peak_n = 0, bell_n = 0, bell_s = GroundReaction::kTransientTime;
    [[nodiscard]] double impulse() const noexcept;             ///< N s
    [[nodiscard]] double force(double since_s) const noexcept; ///< N, so long after at_s
  };

  Track load{0};                    ///< N, without impacts
  Track heel_share{1};              ///< of the load
  Track heel_slip{0}, ball_slip{0}; ///< m/s along the ground, 0 at the end
  std::array<Impact, 2> impacts{};
  double heel_up_s = -1;      ///< negative: the heel does not leave before the rest
  bool unloads_other = false; ///< its load is taken from the other foot, which carries the body
  bool ends_standing = false; ///< keeps its last load; else the foot leaves the ground at the end

  /// To be called once before it is played: where it begins loaded, that is no sudden change.
  void start() noexcept;
  /// Adds the next sample to what the foot does.
  void advance(double step_s, SoleState& sole) noexcept;
  [[nodiscard]] bool active() const noexcept { return active_; }
  /// Stands with a load that does not change any more.
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
  double impacts_end_s_ = 0; ///< from then on no part lands and no impact bears a force
  std::size_t load_piece_ = 0, share_piece_ = 0, heel_slip_piece_ = 0, ball_slip_piece_ = 0;
};

} // namespace tactus::footstep

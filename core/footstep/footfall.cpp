#include "core/footstep/footfall.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <numbers>

namespace tactus::footstep {

double Footfall::Impact::impulse() const noexcept {
  return peak_n * 2 / std::numbers::pi * Landing::kImpactTime + 0.5 * bell_n * bell_s;
}

void Footfall::start() noexcept {
  active_ = true;
  heel_is_up_ = false;
  landed_ = {};
  time_s_ = 0;
  impacts_end_s_ = 0;
  for (const Impact& impact : impacts)
    impacts_end_s_ =
        std::max(impacts_end_s_, impact.at_s + std::max(Landing::kImpactTime, impact.bell_s));
  load_piece_ = share_piece_ = heel_slip_piece_ = ball_slip_piece_ = 0;
  heel_n_ = load.at(0) * heel_share.at(0);
  ball_n_ = load.at(0) - heel_n_;
}

double Footfall::Impact::force(double since_s) const noexcept {
  if (!(since_s > 0) || !(speed_m_per_s > 0))
    return 0;
  double force = 0;
  if (since_s < Landing::kImpactTime)
    force = peak_n * math::sin(std::numbers::pi * since_s / Landing::kImpactTime);
  if (bell_n > 0 && since_s < bell_s) {
    const double sine = math::sin(std::numbers::pi * since_s / bell_s);
    force += bell_n * sine * sine;
  }
  return force;
}

/// Reports the parts of the sole that land in this sample.
void Footfall::land(SoleState& sole) noexcept {
  for (std::size_t i = 0; i < impacts.size(); ++i) {
    const Impact& impact = impacts[i];
    if (landed_[i] || !(impact.speed_m_per_s > 0) || time_s_ < impact.at_s)
      continue;
    landed_[i] = true;
    double& landing = impact.heel ? sole.heel_landing : sole.ball_landing;
    landing = std::max(landing, impact.speed_m_per_s);
  }
}

void Footfall::advance(double step_s, SoleState& sole) noexcept {
  if (!active_)
    return;
  const bool impacts_under_way = time_s_ < impacts_end_s_;
  if (impacts_under_way)
    land(sole);
  time_s_ += step_s;
  const double total_n = load.at(time_s_, load_piece_);
  double heel = total_n * std::clamp(heel_share.at(time_s_, share_piece_), 0.0, 1.0);
  double ball = total_n - heel;
  if (impacts_under_way)
    for (const Impact& impact : impacts)
      (impact.heel ? heel : ball) += impact.force(time_s_ - impact.at_s);
  const bool ends = !ends_standing && time_s_ >= load.duration_s();
  if (ends)
    heel = ball = 0;
  sole.heel_n += heel;
  sole.ball_n += ball;
  sole.heel_slope += (heel - heel_n_) / step_s;
  sole.ball_slope += (ball - ball_n_) / step_s;
  heel_n_ = heel;
  ball_n_ = ball;
  if (time_s_ < heel_slip.duration_s())
    sole.heel_slip = std::max(sole.heel_slip, heel_slip.at(time_s_, heel_slip_piece_));
  if (time_s_ < ball_slip.duration_s())
    sole.ball_slip = std::max(sole.ball_slip, ball_slip.at(time_s_, ball_slip_piece_));
  if (!heel_is_up_ && heel_up_s >= 0 && time_s_ >= heel_up_s) {
    heel_is_up_ = true;
    sole.heel_up = true;
  }
  if (ends) {
    active_ = false;
    sole.toe_off = true;
  }
}

} // namespace tactus::footstep

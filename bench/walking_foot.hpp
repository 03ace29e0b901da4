#pragma once

#include "core/footstep/foot.hpp"
#include "core/footstep/gait.hpp"

#include <array>
#include <cstdint>
#include <memory>

/// One foot of a walker on one ground, in the open and with drives that no limit holds: what the
/// programs that measure recipes and their tests have in common.
namespace tactus::bench {

struct Walk {
  double speed_m_per_s = 1.4, weight_n = 700, shoe = 0.4;
  footstep::Style style = footstep::Style::kWalk;
};

class WalkingFoot {
public:
  WalkingFoot(const footstep::Recipe& recipe, const Walk& walk, double sample_rate,
              std::uint64_t seed)
      : foot_(std::make_unique<footstep::Foot>()) {
    foot_->prepare(sample_rate);
    foot_->seed(seed);
    foot_->set_room(0);
    foot_->set_shoe(walk.shoe);
    foot_->set_weight(walk.weight_n);
    foot_->set_grounds(1, recipe, 1, recipe, 0);
    foot_->drive().set({.limit_g = 1e6});
    gait_.prepare(sample_rate);
    gait_.seed(seed);
    gait_.set({walk.speed_m_per_s, walk.weight_n, walk.shoe, walk.style}, 0.04);
    gait_.walk(true);
  }
  footstep::Gait& gait() noexcept { return gait_; }
  /// One sample.
  footstep::Foot::Out next() noexcept {
    gait_.next(soles_);
    return foot_->next(soles_[0]);
  }
  /// In the last sample.
  [[nodiscard]] bool heel_lands() const noexcept { return soles_[0].heel_landing > 0; }
  [[nodiscard]] const footstep::SoleState& sole() const noexcept { return soles_[0]; }

private:
  std::unique_ptr<footstep::Foot> foot_;
  footstep::Gait gait_;
  std::array<footstep::SoleState, footstep::Gait::kFeet> soles_{};
};

} // namespace tactus::bench

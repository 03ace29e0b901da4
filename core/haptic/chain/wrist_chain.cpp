#include "core/haptic/chain/wrist_chain.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::haptic {

WristCommand WristChain::step(const WristCommand& requested, const ChainState& chain,
                              const Caps& caps, bool homed, double period_s) noexcept {
  if (chain.latched || !homed) {
    sent_ = {};
    return sent_;
  }
  const double gain = chain.motors ? chain.alive_gain * chain.enable_gain : 0;
  const double max_fraction = std::clamp(period_s / kRise_s, 0.0, 1.0); // share of the peak, in one
                                                                        // tick
  const Vec3 torque = limited(requested.torque_n_m, caps.peak_torque_n_m) * gain;
  sent_.torque_n_m += limited(torque - sent_.torque_n_m, caps.peak_torque_n_m * max_fraction);
  const double grip = std::isfinite(requested.grip_n)
                          ? std::clamp(requested.grip_n, -caps.peak_grip_n, caps.peak_grip_n) * gain
                          : 0;
  const double max_change = caps.peak_grip_n * max_fraction;
  sent_.grip_n += std::clamp(grip - sent_.grip_n, -max_change, max_change);
  return sent_;
}

} // namespace tactus::haptic

#pragma once

#include "core/haptic/chain/chain.hpp"
#include "core/haptic/device/device.hpp"

namespace tactus::haptic {

/// What the host wants of wrist and gripper: newest wins. Project frame.
struct WristRequest {
  bool on = false; ///< else the device is not asked for torque or gripper force at all
  WristCommand command{};
};

/// The safety chain of torque and gripper force, beside the force's (chain.hpp) and with its gains:
///
///   clamp to the device's peak -> watchdog and enable gain -> slew -> none when stopped
///
/// What is not finite is no torque, or no grip. The passivity controller does not see them: a patch
/// that renders angular stiffness keeps it low and adds damping.
class WristChain {
public:
  static constexpr double kRise_s = 0.02; ///< from none to the peak, by the slew stage

  void reset() noexcept { sent_ = {}; }
  /// One tick, after the force's; returns what to send. homed: else nothing is sent.
  [[nodiscard]] WristCommand step(const WristCommand& requested, const ChainState& chain,
                                  const Caps& caps, bool homed, double period_s) noexcept;

private:
  WristCommand sent_{};
};

} // namespace tactus::haptic

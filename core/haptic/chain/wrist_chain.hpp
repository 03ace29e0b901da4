#pragma once

#include "core/haptic/chain/chain.hpp"
#include "core/haptic/device/device.hpp"

namespace tactus::haptic {

/// The host's request for torque and gripper force, project frame. The newest one counts.
struct WristRequest {
  bool on = false; ///< false: nothing is sent to the wrist's and gripper's motors
  WristCommand command{};
};

/// The safety chain of torque and gripper force. It uses the gains of the force's chain
/// (chain.hpp):
///
///   clamp to the device's peak -> watchdog and enable gain -> slew limit -> zero when stopped
///
/// A request that is not finite counts as zero. The passivity controller does not observe torque
/// and grip: a patch that renders an angular spring must keep it soft and add damping.
class WristChain {
public:
  static constexpr double kRise_s = 0.02; ///< slew limit: from zero to the peak in this time

  void reset() noexcept { sent_ = {}; }
  /// Makes one tick, after the force's chain, and returns the command to send. The command is zero
  /// while the device is not homed.
  [[nodiscard]] WristCommand step(const WristCommand& requested, const ChainState& chain,
                                  const Caps& caps, bool homed, double period_s) noexcept;

private:
  WristCommand sent_{};
};

} // namespace tactus::haptic

#pragma once

#include "net/server.hpp"

namespace tactus::net {

/// Passes a server's commands to a servo and the servo's reports to the server, through the servo's
/// exchange: neither side waits for the other. The servo contains the force chain; this class sets
/// its limit, its watchdog and its motors. It never releases an emergency stop.
class ServoLink {
public:
  /// The servo is attached to its device with the model among its local models. chain: what the
  /// program sets for this device; force limit, watchdog and allowance are the server's.
  ServoLink(haptic::Servo& servo, RenderModel& model, const haptic::ChainSettings& chain,
            const haptic::AxisMap& map = {});

  /// Once a millisecond, by the thread of the server.
  void exchange(Server& server, double now_s);
  /// Sends only the commands, as soon as something has been received.
  void send(const ServoCommand& servo_command) noexcept;

private:
  haptic::Exchange& exchange_;
  RenderModel& model_;
  haptic::ServoSettings settings_{};
  RenderRequest sent_{};
  bool running_ = false;
  std::uint64_t starts_ = 0;
};

} // namespace tactus::net

#pragma once

#include "net/server.hpp"

namespace tactus::net {

/// Passes a server's commands to a servo and the servo's reports to the server, through the servo's
/// exchange: neither side waits for the other. The servo contains the force chain; this class sets
/// its limit, its watchdog and its motors. It never releases an emergency stop.
class ServoLink {
public:
  /// The servo must be attached to its device, with the model among its local models. chain: the
  /// program's settings for this device, except that the server sets force limit, watchdog and
  /// allowance.
  ServoLink(haptic::Servo& servo, RenderModel& model, const haptic::ChainSettings& chain,
            const haptic::AxisMap& map = {});

  /// The server's thread calls it once a millisecond.
  void exchange(Server& server, double now_s);
  /// Sends only the commands; called as soon as something has been received.
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

#pragma once

#include "core/haptic/servo/servo.hpp"
#include "externals/phantom/reports.hpp"

#include <string>

namespace tactus::phantom {

/// Torque on the handle and force of the gripper, for devices with motors for them. Off until
/// `torques 1`. The messages return a sentence when they are refused.
class Wrist {
public:
  using Words = std::span<const Atom>;

  /// `open`: the device is open, so that its capabilities are known.
  [[nodiscard]] std::string enable(Words words, bool open, const haptic::Caps& caps,
                                   haptic::Exchange& exchange);
  [[nodiscard]] std::string set_torque(Words words, haptic::Exchange& exchange);
  [[nodiscard]] std::string set_grip(Words words, haptic::Exchange& exchange);
  /// Gives the request to a servo.
  void publish(haptic::Exchange& exchange) const { exchange.wrist.write(request_); }
  /// Sends `torque` and `grip` of a report; `all`: also where no tag asks for them.
  void send(const haptic::Report& report, bool all, bool has_gripper, const Reports& reports,
            Host& host) const;

private:
  [[nodiscard]] std::string set(const haptic::WristCommand& command, std::string_view message,
                                haptic::Exchange& exchange);
  haptic::WristRequest request_{};
};

} // namespace tactus::phantom

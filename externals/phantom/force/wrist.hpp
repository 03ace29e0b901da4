#pragma once

#include "externals/phantom/device/device_link.hpp"
#include "externals/phantom/reports.hpp"
#include "externals/phantom/words.hpp"

#include <string_view>

namespace tactus::phantom {

/// Torque on the handle and force of the gripper, for devices with motors for them. Off until
/// `torques 1`.
class Wrist {
public:
  Wrist(const ServoSession& session, const DeviceLink& link, const Reports& reports)
      : session_(session), link_(link), reports_(reports) {}

  void enable(const Atom& on, Host& host);
  void set_torque(Words words, Host& host);
  void set_grip(Words words, Host& host);
  /// Passes the request to the servo.
  void publish() const { session_.exchange().wrist.write(request_); }
  /// Sends `torque` and `grip` of a report; `all`: sends them even if their tags are off.
  void send(const haptic::Report& report, bool all, Host& host) const;

private:
  void set(const haptic::WristCommand& command, std::string_view message, Host& host);

  const ServoSession& session_;
  const DeviceLink& link_;
  const Reports& reports_;
  haptic::WristRequest request_{};
};

} // namespace tactus::phantom

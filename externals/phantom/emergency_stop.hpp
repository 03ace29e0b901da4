#pragma once

#include "core/haptic/device/motor_control.hpp"
#include "externals/phantom/reports.hpp"

#include <string>
#include <vector>

namespace tactus::phantom {

/// The emergency stop of one object. It is also latched for the object's name and its device
/// (estop_latches.hpp), so that it holds for the object that replaces this one.
class EmergencyStop {
public:
  /// Latches it under a key, until release().
  void latch(const std::string& key);
  /// Takes over the stop of an earlier object with that key; false: there is none.
  [[nodiscard]] bool inherit(const std::string& key, haptic::MotorControl& motors, Host& host);
  /// Releases all latches of this object.
  void release() noexcept;
  /// Sends `status estop` when it has changed; `again`: in any case when it is stopped.
  void report(const haptic::MotorControl& motors, const Reports& reports, Host& host,
              bool again = false);

private:
  std::vector<std::string> keys_;
  bool reported_ = false;
};

} // namespace tactus::phantom

#include "externals/phantom/emergency_stop.hpp"

#include "externals/phantom/estop_latches.hpp"

#include <algorithm>

namespace tactus::phantom {

void EmergencyStop::latch(const std::string& key) {
  latch_estop(key);
  if (std::find(keys_.begin(), keys_.end(), key) == keys_.end())
    keys_.push_back(key);
}

bool EmergencyStop::inherit(const std::string& key, haptic::MotorControl& motors, Host& host) {
  if (!estop_latched(key))
    return false;
  if (!motors.request().stopped)
    host.log("the estop of an earlier phantom of the same name or device is still active: send "
             "motors 1 to enable the force");
  motors.emergency_stop();
  keys_.push_back(key);
  return true;
}

void EmergencyStop::release() noexcept {
  for (const std::string& key : keys_)
    release_estop(key);
  keys_.clear();
}

void EmergencyStop::report(const haptic::MotorControl& motors, const Reports& reports, Host& host,
                           bool again) {
  const bool stopped = motors.request().stopped;
  if (stopped == (reported_ && !again))
    return;
  reported_ = stopped;
  reports.send(kStatus, {"status", "estop", stopped ? 1.0 : 0.0}, host);
}

} // namespace tactus::phantom

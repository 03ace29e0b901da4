#include "externals/phantom/estop_latches.hpp"
#include "externals/phantom/phantom.hpp"
#include "externals/phantom/tags.hpp"

#include <algorithm>

/// `motors` and `estop`: requests to the servo's MotorControl. A stop is also latched for the
/// object's name and its device, so that it holds for the object that replaces this one.
namespace tactus {

using namespace phantom;

void Phantom::set_motors() noexcept {
  if (!given_.motors)
    return exchange().motors.disable();
  exchange().motors.enable();
  for (const std::string& key : estop_keys_)
    release_estop(key);
  estop_keys_.clear();
}

void Phantom::on_estop(Host& host) {
  exchange().motors.emergency_stop();
  latch_stop();
  estop_reported_ = false;
  send_estop(host);
}

/// Switches the motors off until `motors 1`; the parameter then reads 0.
void Phantom::switch_off() noexcept {
  given_.motors = false;
  exchange().motors.disable();
}

/// Latches the stop for this name and this device.
void Phantom::latch_stop() noexcept {
  given_.motors = false;
  const auto latch = [this](std::string key) {
    latch_estop(key);
    if (std::find(estop_keys_.begin(), estop_keys_.end(), key) == estop_keys_.end())
      estop_keys_.push_back(std::move(key));
  };
  if (name_ != "-")
    latch(name_key(name_));
  if (driver_ && (open() || link_ == Link::kLost))
    latch(device_key_);
}

/// Applies the stop that an earlier object latched for this name or device.
void Phantom::inherit_stop(const std::string& key, Host& host) {
  if (!estop_latched(key))
    return;
  if (!exchange().motors.request().stopped)
    host.log("the estop of an earlier phantom of the same name or device is still active: send "
             "motors 1 to enable the force");
  exchange().motors.emergency_stop();
  given_.motors = false;
  estop_keys_.push_back(key);
  send_estop(host);
}

void Phantom::send_estop(Host& host) {
  const bool stopped = exchange().motors.request().stopped;
  if (stopped == estop_reported_)
    return;
  estop_reported_ = stopped;
  if (reported_[kStatus])
    host.info({"status", "estop", stopped ? 1.0 : 0.0});
}

} // namespace tactus

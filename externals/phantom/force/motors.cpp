#include "externals/phantom/force/motors.hpp"

#include "externals/phantom/force/motor_memory.hpp"

#include <algorithm>

namespace tactus::phantom {

void Motors::set(bool on) noexcept {
  if (!on)
    return switch_off();
  on_ = true;
  control().enable();
  for (const std::string& key : latched_)
    release_estop(key);
  latched_.clear();
}

void Motors::switch_off() noexcept {
  on_ = false;
  control().disable();
}

void Motors::emergency_stop() {
  control().emergency_stop();
  latch();
}

void Motors::stop(Host& host) {
  emergency_stop();
  report(host, true);
}

void Motors::report(Host& host, bool again) {
  const bool stopped = control().request().stopped;
  if (stopped == (reported_ && !again))
    return;
  reported_ = stopped;
  reports_.send(kStatus, {"status", "estop", stopped ? 1.0 : 0.0}, host);
}

void Motors::set_name(std::string_view name, Host& host) {
  name_key_ = name == "-" ? std::string() : name_key(name);
  inherit(name_key_, host);
}

void Motors::begin_device(std::string_view driver, std::string_view serial, Host& host) {
  device_key_ = device_key(driver, serial);
  session_.rig().servo.set_motor_heat(motor_heat_n2(device_key_, devices::ServoThread::now_s()));
  inherit(device_key_, host);
}

void Motors::store_heat() noexcept {
  session_.exchange().reports.read();
  store_motor_heat(device_key_, session_.exchange().reports.latest().heat_n2,
                   devices::ServoThread::now_s());
}

/// Latches the stop for the name and the device.
void Motors::latch() {
  on_ = false;
  for (const std::string& key : {name_key_, device_key_})
    if (!key.empty()) {
      latch_estop(key);
      if (std::find(latched_.begin(), latched_.end(), key) == latched_.end())
        latched_.push_back(key);
    }
}

/// Applies the stop that an earlier object latched under the key. If this object is stopped,
/// latches its stop under the key.
void Motors::inherit(const std::string& key, Host& host) {
  const bool stopped = control().request().stopped, latched = estop_latched(key);
  if (!stopped && latched)
    host.log("the estop of an earlier phantom of the same name or device is still active: send "
             "motors 1 to enable the force");
  if (latched)
    control().emergency_stop();
  if (stopped || latched)
    latch();
  if (latched)
    report(host);
}

} // namespace tactus::phantom

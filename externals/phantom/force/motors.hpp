#pragma once

#include "externals/phantom/reports.hpp"
#include "externals/phantom/servo/servo_session.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tactus::phantom {

/// The motors' switch, their emergency stop and their heat. An object that replaces this one takes
/// over the stop and the heat: motor_memory.hpp.
class Motors {
public:
  Motors(const ServoSession& session, const Reports& reports)
      : session_(session), reports_(reports) {}

  [[nodiscard]] bool on() const noexcept { return on_; }
  /// Handles `motors 0|1`; 1 also releases all stops.
  void set(bool on) noexcept;
  /// Switches the motors off until `motors 1`. Until then the parameter `motors` is 0.
  void switch_off() noexcept;
  /// Stops the motors until `motors 1`. The stop is latched for the object's name and its device.
  void emergency_stop();
  /// Handles the message `estop`.
  void stop(Host& host);
  /// Sends `status estop` if the stop has changed or, with `again`, whenever it is active.
  void report(Host& host, bool again = false);

  /// Set the object's name, `-` for none, and its real device while that is open or lost. A stop
  /// that is latched for either one takes effect.
  void set_name(std::string_view name, Host& host);
  void begin_device(std::string_view driver, std::string_view serial, Host& host);
  void end_device() noexcept { device_key_.clear(); }
  /// Stores the heat for the next servo that drives the device.
  void store_heat() noexcept;

private:
  void latch();
  void inherit(const std::string& key, Host& host);
  [[nodiscard]] haptic::MotorControl& control() const noexcept {
    return session_.exchange().motors;
  }

  const ServoSession& session_;
  const Reports& reports_;
  bool on_ = true, reported_ = false;
  std::string name_key_, device_key_; ///< each empty if there is none
  std::vector<std::string> latched_;  ///< keys that `motors 1` releases
};

} // namespace tactus::phantom

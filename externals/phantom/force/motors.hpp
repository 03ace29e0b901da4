#pragma once

#include "externals/phantom/reports.hpp"
#include "externals/phantom/servo/servo_session.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tactus::phantom {

/// The motors' switch, their emergency stop and their heat. Stop and heat also hold for the object
/// that replaces this one: motor_memory.hpp.
class Motors {
public:
  Motors(const ServoSession& session, const Reports& reports)
      : session_(session), reports_(reports) {}

  [[nodiscard]] bool on() const noexcept { return on_; }
  /// `motors 0|1`: 1 also releases all stops.
  void set(bool on) noexcept;
  /// Off until `motors 1`; the parameter then reads 0.
  void switch_off() noexcept;
  /// An emergency stop until `motors 1`, latched for the object's name and its device.
  void emergency_stop();
  /// The message `estop`.
  void stop(Host& host);
  /// Sends `status estop` when it has changed; `again`: in any case when it is stopped.
  void report(Host& host, bool again = false);

  /// The object's name, or - for none, and its real device while that is open or lost. A stop that
  /// is latched for them holds.
  void set_name(std::string_view name, Host& host);
  void begin_device(std::string_view driver, std::string_view serial, Host& host);
  void end_device() noexcept { device_key_.clear(); }
  /// For the next servo that drives the device.
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
  std::string name_key_, device_key_; ///< empty: none
  std::vector<std::string> latched_;  ///< keys that `motors 1` releases
};

} // namespace tactus::phantom

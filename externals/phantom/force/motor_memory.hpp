#pragma once

#include <string>
#include <string_view>

/// Emergency stops and the heat of motors, stored by an object's name or by its real device. They
/// outlive the object, since editing a patch recreates its objects. An emergency stop lasts until
/// `motors 1`. All are stored for the life of the process and used by the host's threads.
namespace tactus::phantom {

[[nodiscard]] std::string name_key(std::string_view name);
/// The key of one real device; serial is empty if the device has none. A driver's devices without a
/// serial number share one key.
[[nodiscard]] std::string device_key(std::string_view driver, std::string_view serial);

void latch_estop(const std::string& key);
void release_estop(const std::string& key) noexcept;
[[nodiscard]] bool estop_latched(const std::string& key);

/// heat_n2: h of haptic::ThermalLimit, N^2; now_s: time of one steady clock. The highest heat of a
/// key counts.
void store_motor_heat(const std::string& key, double heat_n2, double now_s);
/// The remaining heat, N^2; 0 for a device that was never driven.
[[nodiscard]] double motor_heat_n2(const std::string& key, double now_s);

} // namespace tactus::phantom

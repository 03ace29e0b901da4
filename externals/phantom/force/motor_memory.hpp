#pragma once

#include <string>
#include <string_view>

/// What holds for a name or a real device beyond the object that has it, since editing a patch
/// recreates its objects: emergency stops, until `motors 1`, and the heat of a device's motors.
/// Stored for the life of the process; for the host's threads.
namespace tactus::phantom {

[[nodiscard]] std::string name_key(std::string_view name);
/// The key of one real device; serial is empty where the device states none. Such devices of one
/// driver share a key.
[[nodiscard]] std::string device_key(std::string_view driver, std::string_view serial);

void latch_estop(const std::string& key);
void release_estop(const std::string& key) noexcept;
[[nodiscard]] bool estop_latched(const std::string& key);

/// heat_n2: h of haptic::ThermalLimit, N^2; now_s: of one steady clock. The highest heat of a key
/// counts.
void store_motor_heat(const std::string& key, double heat_n2, double now_s);
/// The remaining heat, N^2; 0 for a device that was never driven.
[[nodiscard]] double motor_heat_n2(const std::string& key, double now_s);

} // namespace tactus::phantom

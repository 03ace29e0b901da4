#pragma once

#include <string>

/// The heat of real devices' motors when they were closed. The next servo that drives a device
/// starts with the remaining heat, also in another object. Stored for the life of the process; for
/// the host's threads.
namespace tactus::phantom {

/// heat_n2: h of haptic::ThermalLimit, N^2; key: of estop_latches.hpp; now_s: of one steady clock.
/// Devices without a serial number share a key; the highest heat counts.
void store_motor_heat(const std::string& key, double heat_n2, double now_s);
/// The remaining heat, N^2; 0 for a device that was never driven.
[[nodiscard]] double motor_heat_n2(const std::string& key, double now_s);

} // namespace tactus::phantom

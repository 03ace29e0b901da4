#pragma once

#include <string>

/// How warm the motors of real devices were when an object let them go. Heat stays in a device that
/// is closed, unplugged or given to another object, so the next servo that drives it begins with
/// what is left. Kept for the life of the process; for the host's threads.
namespace tactus::phantom {

/// heat_n2: h of haptic::ThermalLimit, N^2; key: of estop_latches.hpp; now_s: of one steady clock.
/// Devices that share a key, since they tell no serial number, share the highest heat.
void store_motor_heat(const std::string& key, double heat_n2, double now_s);
/// What is left of it, N^2; 0 for a device that was never driven.
[[nodiscard]] double motor_heat_n2(const std::string& key, double now_s);

} // namespace tactus::phantom

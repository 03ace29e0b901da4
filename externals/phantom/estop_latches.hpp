#pragma once

#include <string>
#include <string_view>

/// Emergency stops by the name of an object and by its real device. They outlive the object, since
/// editing a patch recreates its objects; `motors 1` releases both. Stored for the life of the
/// process; for the host's threads.
namespace tactus::phantom {

[[nodiscard]] std::string name_key(std::string_view name);
/// The key of one real device; serial is empty where the device states none.
[[nodiscard]] std::string device_key(std::string_view driver, std::string_view serial);

void latch_estop(const std::string& key);
void release_estop(const std::string& key) noexcept;
[[nodiscard]] bool estop_latched(const std::string& key);

} // namespace tactus::phantom

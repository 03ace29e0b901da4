#pragma once

#include <string>
#include <string_view>

/// Emergency stops that outlive the object to which they were said: a patch that is edited makes
/// its objects anew. A stop belongs to the object's name and to the real device it has; `motors 1`
/// releases both. Kept for the life of the process; for the host's threads.
namespace tactus::phantom {

[[nodiscard]] std::string name_key(std::string_view name);
/// Of one real device; serial is empty where the device tells none.
[[nodiscard]] std::string device_key(std::string_view driver, std::string_view serial);

void latch_estop(const std::string& key);
void release_estop(const std::string& key) noexcept;
[[nodiscard]] bool estop_latched(const std::string& key);

} // namespace tactus::phantom

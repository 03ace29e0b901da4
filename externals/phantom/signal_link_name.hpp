#pragma once

#include <string>
#include <string_view>

namespace tactus::phantom {

/// Under which a device offers its haptic::SignalLink. The number changes with the type's layout.
[[nodiscard]] inline std::string signal_link_name(std::string_view device) {
  return "tactus haptic signals 2 " + std::string(device);
}

} // namespace tactus::phantom

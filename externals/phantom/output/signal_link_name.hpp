#pragma once

#include <string>
#include <string_view>

namespace tactus::phantom {

/// The name under which [phantom] publishes its haptic::SignalLink. The number in it must change
/// whenever the layout of that class does.
[[nodiscard]] inline std::string signal_link_name(std::string_view device) {
  return "tactus haptic signals 2 " + std::string(device);
}

} // namespace tactus::phantom

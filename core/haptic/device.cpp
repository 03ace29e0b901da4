#include "core/haptic/device.hpp"

namespace tactus::haptic {

std::string Backend::configure(std::span<const std::string> words) {
  return words.empty() ? "a setting has a name" : words[0] + " is not a setting of this device";
}

} // namespace tactus::haptic

#pragma once

#include "core/haptic/device/path.hpp"
#include "externals/phantom/words.hpp"

#include <string>

namespace tactus::phantom {

/// The path that the message `path ...` selects, or the sentence that refuses the message.
struct PathChoice {
  haptic::Path path{};
  std::string refusal{};
};
[[nodiscard]] PathChoice choose_path(Words words, const Host& host);

} // namespace tactus::phantom

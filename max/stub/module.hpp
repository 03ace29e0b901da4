#pragma once

#include <string>

namespace tactus::stub {
/// Loads an external and runs its ext_main. Empty, or why it could not be loaded.
[[nodiscard]] std::string load_external(const std::string& file);
} // namespace tactus::stub

#pragma once

#include <filesystem>
#include <string>

/// Paths are UTF-8 in scripts and in Max, on every system.
namespace tactus::stub {
[[nodiscard]] inline std::filesystem::path from_utf8(const std::string& text) {
  return {std::u8string(text.begin(), text.end())};
}
[[nodiscard]] inline std::string to_utf8(const std::filesystem::path& path) {
  const std::u8string text = path.generic_u8string();
  return {text.begin(), text.end()};
}
} // namespace tactus::stub

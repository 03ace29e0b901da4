#pragma once

#include <exception>
#include <filesystem>
#include <string>
#include <string_view>

namespace tactus {

/// The path that a host's text names: hosts give UTF-8, which Windows would otherwise read in the
/// code page of its user. Elsewhere the bytes as they are. Empty, which names no file, for text
/// that is not UTF-8 on Windows.
[[nodiscard]] inline std::filesystem::path utf8_path(std::string_view text) {
#ifdef _WIN32
  try {
    return {std::u8string(text.begin(), text.end())};
  } catch (const std::exception&) {
    return {};
  }
#else
  return {std::string(text)};
#endif
}

/// A path as a host's text: the inverse.
[[nodiscard]] inline std::string to_utf8(const std::filesystem::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}
/// The same with slashes on every system.
[[nodiscard]] inline std::string to_generic_utf8(const std::filesystem::path& path) {
  return to_utf8(path.generic_u8string());
}

} // namespace tactus

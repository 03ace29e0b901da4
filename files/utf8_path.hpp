#pragma once

#include <exception>
#include <filesystem>
#include <string>
#include <string_view>

namespace tactus {

/// The path that a text of the host names. Hosts give UTF-8, which Windows would otherwise read in
/// the user's code page. On other systems the bytes are used unchanged. On Windows a text that is
/// not UTF-8 gives an empty path, which names no file.
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

/// Converts a path to a text for the host; the inverse of utf8_path().
[[nodiscard]] inline std::string to_utf8(const std::filesystem::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}
/// As to_utf8(), but with slashes on every system.
[[nodiscard]] inline std::string to_generic_utf8(const std::filesystem::path& path) {
  return to_utf8(path.generic_u8string());
}

} // namespace tactus

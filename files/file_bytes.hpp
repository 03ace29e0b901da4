#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::files {

/// Opens a regular file for reading. For anything else the stream is in the failed state, because
/// reading a FIFO or a device could block for ever.
[[nodiscard]] std::ifstream open_file(std::string_view path);

/// Reads a whole regular file. Returns an empty text, or a sentence if reading fails.
inline constexpr std::uint64_t kMaxFileBytes = std::uint64_t{2} << 30;
[[nodiscard]] std::string read_file(std::string_view path, std::vector<std::byte>& bytes,
                                    std::uint64_t max_bytes = kMaxFileBytes);
[[nodiscard]] std::string read_file(std::string_view path, std::string& text,
                                    std::uint64_t max_bytes);

} // namespace tactus::files

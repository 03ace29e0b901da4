#pragma once

#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

namespace tactus {

/// A whole file below 2 GB; returns why it cannot be read, to follow the file's name, else nothing.
[[nodiscard]] inline std::string read_file(const std::string& path, std::vector<std::byte>& bytes) {
  constexpr std::streamoff kMaxBytes = std::streamoff{2} << 30;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file)
    return "it cannot be opened";
  const std::streamoff size = file.tellg();
  if (size < 0 || size > kMaxBytes)
    return "it is no file of less than 2 GB";
  bytes.resize(static_cast<std::size_t>(size));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), size))
    return "it cannot be read";
  return {};
}

} // namespace tactus

#include "files/file_bytes.hpp"

#include "files/utf8_path.hpp"

#include <fstream>

namespace tactus::files {

std::string read_file(const std::string& path, std::vector<std::byte>& bytes) {
  constexpr std::streamoff kMaxBytes = std::streamoff{2} << 30;
  std::ifstream file(utf8_path(path), std::ios::binary | std::ios::ate);
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

} // namespace tactus::files

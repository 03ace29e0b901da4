#include "files/file_bytes.hpp"

#include "files/utf8_path.hpp"

#include <system_error>

namespace tactus::files {
namespace {

template <class Bytes> std::string read(std::string_view path, Bytes& bytes, std::uint64_t max) {
  std::ifstream file = open_file(path);
  std::error_code failed;
  const std::uint64_t size = std::filesystem::file_size(utf8_path(path), failed);
  if (!file || failed)
    return "it is not a readable file";
  if (size > max)
    return "it has " + std::to_string(size) + " bytes: expected at most " + std::to_string(max);
  bytes.resize(static_cast<std::size_t>(size));
  if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    return "it cannot be read";
  return {};
}

} // namespace

std::ifstream open_file(std::string_view path) {
  const std::filesystem::path named = utf8_path(path);
  std::error_code failed;
  std::ifstream file;
  if (std::filesystem::is_regular_file(named, failed))
    file.open(named, std::ios::binary);
  else
    file.setstate(std::ios::failbit);
  return file;
}

std::string read_file(std::string_view path, std::vector<std::byte>& bytes,
                      std::uint64_t max_bytes) {
  return read(path, bytes, max_bytes);
}
std::string read_file(std::string_view path, std::string& text, std::uint64_t max_bytes) {
  return read(path, text, max_bytes);
}

} // namespace tactus::files

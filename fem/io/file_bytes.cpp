#include "fem/io/file_bytes.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/mesh.hpp"

#include <filesystem>
#include <fstream>

namespace tactus::fem {

std::string read_bytes(const std::string& path, std::uint64_t largest) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw InputError("cannot read " + path + ": no such file");
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error)
    throw InputError("cannot read " + path + ": " + error.message());
  if (size > largest)
    throw InputError(path + format(" is %.3g GB large, expected %.3g GB at most",
                                   1e-9 * static_cast<double>(size),
                                   1e-9 * static_cast<double>(largest)));
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file || (size > 0 && !file.read(bytes.data(), static_cast<std::streamsize>(size))))
    throw InputError("cannot read " + path);
  return bytes;
}

} // namespace tactus::fem

#include "externals/program_file.hpp"

#include <system_error>
#include <unistd.h>

namespace tactus {

bool is_program_path(const std::string& text) { return text.find('/') != std::string::npos; }

std::filesystem::path runnable(const std::filesystem::path& path) {
  std::error_code error;
  const bool can_run =
      std::filesystem::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
  return can_run ? path : std::filesystem::path();
}

} // namespace tactus

#include "externals/program_file.hpp"

#include <system_error>

namespace tactus {

bool is_program_path(const std::string& text) {
  return text.find_first_of("/\\") != std::string::npos;
}

std::filesystem::path runnable(const std::filesystem::path& path) {
  std::filesystem::path program = path;
  if (program.extension() != ".exe")
    program += ".exe";
  std::error_code error;
  return std::filesystem::is_regular_file(program, error) ? program : std::filesystem::path();
}

} // namespace tactus

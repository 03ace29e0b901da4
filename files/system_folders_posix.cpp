#include "files/system_folders.hpp"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include <dlfcn.h>
#include <unistd.h>

namespace tactus {

std::filesystem::path own_folder() {
  Dl_info found{};
  static const char here = 0;
  if (::dladdr(&here, &found) == 0 || !found.dli_fname)
    return {};
  return std::filesystem::path(found.dli_fname).parent_path();
}

std::vector<std::filesystem::path> folders_in_path() {
  std::vector<std::filesystem::path> folders;
  const char* path = std::getenv("PATH");
  std::string_view left = path ? path : "";
  while (!left.empty()) {
    const std::string_view folder = left.substr(0, left.find(':'));
    left.remove_prefix(std::min(left.size(), folder.size() + 1));
    if (!folder.empty())
      folders.emplace_back(folder);
  }
  return folders;
}

bool is_program_path(const std::string& text) { return text.find('/') != std::string::npos; }

std::filesystem::path runnable(const std::filesystem::path& path) {
  std::error_code error;
  const bool can_run =
      std::filesystem::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
  return can_run ? path : std::filesystem::path();
}

} // namespace tactus

#include "files/system_folders.hpp"

#include <algorithm>
#include <cstdlib>
#include <dlfcn.h>
#include <string_view>

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

} // namespace tactus

#include "files/system_folders.hpp"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <windows.h>

namespace tactus {

std::filesystem::path own_folder() {
  static const char here = 0;
  HMODULE module = nullptr;
  if (!GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS |
                              GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                          reinterpret_cast<LPCWSTR>(&here), &module))
    return {};
  std::wstring name(32768, L'\0'); // longest path of Windows
  name.resize(GetModuleFileNameW(module, name.data(), static_cast<DWORD>(name.size())));
  return std::filesystem::path(name).parent_path();
}

std::vector<std::filesystem::path> folders_in_path() {
  std::vector<std::filesystem::path> folders;
  const wchar_t* path = _wgetenv(L"PATH");
  std::wstring_view left = path ? path : L"";
  while (!left.empty()) {
    const std::wstring_view folder = left.substr(0, left.find(L';'));
    left.remove_prefix(std::min(left.size(), folder.size() + 1));
    if (std::filesystem::path here(folder); here.is_absolute())
      folders.push_back(std::move(here));
  }
  return folders;
}

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

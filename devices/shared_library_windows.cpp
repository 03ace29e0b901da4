#include "devices/shared_library.hpp"
#include "files/system_folders.hpp"
#include "files/utf8_path.hpp"

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include <windows.h>

namespace tactus::devices {
namespace {

/// The search path for a library's name: beside the module, the folders of the program and of the
/// system, and PATH, to which vendors' installers add theirs. The current folder, which Windows
/// would also search, is left out, so that no code is run from a patch's folder.
std::vector<std::filesystem::path> candidates(const std::filesystem::path& name) {
  std::vector<std::filesystem::path> found;
  if (name.is_absolute())
    return {name};
  found.push_back(own_folder() / name);
  found.push_back(name); // the loader's default folders
  for (const std::filesystem::path& folder : folders_in_path())
    found.push_back(folder / name);
  return found;
}

} // namespace

void* SharedLibrary::open(const char* name, std::string& error, bool& missing) {
  DWORD reason = ERROR_MOD_NOT_FOUND;
  missing = true;
  for (const std::filesystem::path& path : candidates(utf8_path(name))) {
    std::error_code failed;
    if (path.is_absolute() && !std::filesystem::exists(path, failed))
      continue;
    // The library's own dependencies are also searched for beside it.
    const DWORD how = LOAD_LIBRARY_SEARCH_DEFAULT_DIRS |
                      (path.is_absolute() ? LOAD_LIBRARY_SEARCH_DLL_LOAD_DIR : DWORD{0});
    if (HMODULE library = LoadLibraryExW(path.c_str(), nullptr, how)) // never closed
      return library;
    if (const DWORD why = GetLastError(); why != ERROR_MOD_NOT_FOUND || path.is_absolute()) {
      reason = missing ? why : reason; // keeps the reason for the first file that exists
      missing = false;
    }
  }
  error = std::string(name) + " cannot be loaded (error " + std::to_string(reason) + ": " +
          std::system_category().message(static_cast<int>(reason)) + ")";
  return nullptr;
}

void* SharedLibrary::address(const char* symbol_name) const noexcept {
  if (!handle_)
    return nullptr;
  return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(handle_), symbol_name));
}

} // namespace tactus::devices

#include "pd/host_process.hpp"

#include <algorithm>
#include <cstddef>

#include <windows.h>

#include <m_pd.h>

namespace tactus::pd {

// Looks in the DLL that contains a function of Pd, whatever the name of that DLL.
void* host_symbol(const char* name) noexcept {
  HMODULE host = nullptr;
  GetModuleHandleExA(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS |
                         GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                     reinterpret_cast<LPCSTR>(&pd_typedmess), &host);
  return host ? reinterpret_cast<void*>(GetProcAddress(host, name)) : nullptr;
}

// Returns UTF-8, like Pd's own paths.
std::string module_folder() {
  static const char here = 0;
  HMODULE module = nullptr;
  if (!GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS |
                              GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                          reinterpret_cast<LPCWSTR>(&here), &module))
    return {};
  std::wstring wide(32768, L'\0'); // longest path of Windows
  wide.resize(GetModuleFileNameW(module, wide.data(), static_cast<DWORD>(wide.size())));
  std::string path(4 * wide.size(), '\0');
  path.resize(static_cast<std::size_t>(
      WideCharToMultiByte(CP_UTF8, 0, wide.data(), static_cast<int>(wide.size()), path.data(),
                          static_cast<int>(path.size()), nullptr, nullptr)));
  std::replace(path.begin(), path.end(), '\\', '/');
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? std::string() : path.substr(0, slash);
}

bool is_absolute(const std::string& path) noexcept {
  return path.starts_with('/') || path.starts_with('~') || (path.size() > 1 && path[1] == ':');
}

std::string command_line() {
  std::string all(1, '\0');
  bool quoted = false;
  for (const char* c = GetCommandLineA(); *c; ++c) {
    quoted = quoted != (*c == '"');
    if (*c != '"')
      all += *c == ' ' && !quoted ? '\0' : *c;
  }
  all.push_back('\0');
  return all;
}

} // namespace tactus::pd

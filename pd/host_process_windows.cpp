#include "pd/host_process.hpp"

#include <windows.h>

#include <m_pd.h>

namespace tactus::pd {

// In the DLL that a function of Pd's comes from, whatever that is called.
void* host_symbol(const char* name) noexcept {
  HMODULE host = nullptr;
  GetModuleHandleExA(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS |
                         GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                     reinterpret_cast<LPCSTR>(&pd_typedmess), &host);
  return host ? reinterpret_cast<void*>(GetProcAddress(host, name)) : nullptr;
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

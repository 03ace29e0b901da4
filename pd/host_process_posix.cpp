#include "pd/host_process.hpp"

#include <cstddef>
#include <cstdio>

#include <dlfcn.h>
#ifdef __APPLE__
#include <crt_externs.h>
#endif

namespace tactus::pd {

void* host_symbol(const char* name) noexcept { return dlsym(RTLD_DEFAULT, name); }

std::string module_folder() {
  Dl_info found{};
  static const char here = 0;
  if (dladdr(&here, &found) == 0 || !found.dli_fname)
    return {};
  const std::string path = found.dli_fname;
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? std::string() : path.substr(0, slash);
}

bool is_absolute(const std::string& path) noexcept {
  return path.starts_with('/') || path.starts_with('~');
}

std::string command_line() {
  std::string all(1, '\0');
#if defined(__APPLE__)
  for (int i = 0; i < *_NSGetArgc(); ++i)
    all.append((*_NSGetArgv())[i]).push_back('\0');
#else
  if (std::FILE* file = std::fopen("/proc/self/cmdline", "r")) {
    char part[4096];
    for (std::size_t n; (n = std::fread(part, 1, sizeof part, file)) > 0;)
      all.append(part, n);
    std::fclose(file);
  }
#endif
  all.push_back('\0');
  return all;
}

} // namespace tactus::pd

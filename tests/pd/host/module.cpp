// Loads modules by the system's loader, as Pd does.
#include "tests/pd/host.hpp"

#include <string>

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace tactus::test {

std::string load_module(const std::string& file, const std::string& setup) {
#ifdef _WIN32
  const HMODULE module = LoadLibraryA(file.c_str());
  auto* const symbol = module ? GetProcAddress(module, setup.c_str()) : nullptr;
  const std::string why = "error " + std::to_string(GetLastError());
#else
  void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const symbol = module ? dlsym(module, setup.c_str()) : nullptr;
  const std::string why = symbol ? "" : dlerror();
#endif
  if (!symbol)
    return why;
  reinterpret_cast<void (*)()>(symbol)();
  return {};
}

} // namespace tactus::test

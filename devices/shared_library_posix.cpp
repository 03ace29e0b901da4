#include "devices/shared_library.hpp"

#include <dlfcn.h>

namespace tactus::devices {

void* SharedLibrary::open(const char* name, std::string& error) {
  void* handle = dlopen(name, RTLD_NOW | RTLD_LOCAL); // never closed
  if (!handle) {
    const char* reason = dlerror();
    error = reason ? reason : "cannot be loaded";
  }
  return handle;
}

void* SharedLibrary::address(const char* symbol_name) const noexcept {
  return handle_ ? dlsym(handle_, symbol_name) : nullptr;
}

} // namespace tactus::devices

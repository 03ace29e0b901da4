#include "devices/shared_library.hpp"

#ifndef _WIN32
#include <dlfcn.h>
#else
#include <windows.h>
#endif

namespace tactus::devices {

std::string SharedLibrary::joined(std::span<const char* const> names) {
  std::string text;
  for (const char* name : names)
    text += std::string(text.empty() ? "" : ", ") + name;
  return text;
}

#ifndef _WIN32
bool SharedLibrary::load(std::span<const char* const> names) {
  handle_ = nullptr;
  for (const char* name : names) {
    handle_ = dlopen(name, RTLD_NOW | RTLD_LOCAL); // never closed
    if (handle_) {
      name_ = name;
      error_.clear();
      return true;
    }
    const char* reason = dlerror();
    error_ = reason ? reason : "cannot be loaded";
  }
  return false;
}

void* SharedLibrary::address(const char* symbol_name) const noexcept {
  return handle_ ? dlsym(handle_, symbol_name) : nullptr;
}
#else
bool SharedLibrary::load(std::span<const char* const> names) {
  handle_ = nullptr;
  for (const char* name : names) {
    handle_ = LoadLibraryA(name);
    if (handle_) {
      name_ = name;
      error_.clear();
      return true;
    }
    error_ = std::string(name) + " cannot be loaded (error " + std::to_string(GetLastError()) + ")";
  }
  return false;
}

void* SharedLibrary::address(const char* symbol_name) const noexcept {
  if (!handle_)
    return nullptr;
  return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(handle_), symbol_name));
}
#endif

} // namespace tactus::devices

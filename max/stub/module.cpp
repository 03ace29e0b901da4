#include "max/stub/module.hpp"

#include "files/utf8_path.hpp"
#include "max/stub/kernel.hpp"
#include "max/stub/realtime_watch.hpp"

#include <filesystem>

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace tactus::stub {
namespace {
#if defined(_WIN32)
void* open_module(const std::string& file, std::string& reason) {
  // In Max, MaxAPI.dll and MaxAudio.dll are loaded before any external, wherever its file is.
  static const HMODULE audio = LoadLibraryW(L"MaxAudio.dll");
  if (!audio)
    violation("MaxAudio.dll does not lie beside the host");
  const std::filesystem::path path = std::filesystem::absolute(utf8_path(file));
  const HMODULE module = LoadLibraryW(path.c_str());
  if (!module)
    reason = "Windows' error " + std::to_string(GetLastError());
  return module;
}
method find_function(void* module, const char* name) {
  return reinterpret_cast<method>(
      reinterpret_cast<void (*)()>(GetProcAddress(static_cast<HMODULE>(module), name)));
}
#else
void* open_module(const std::string& file, std::string& reason) {
  void* module = dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!module)
    reason = dlerror();
  return module;
}
method find_function(void* module, const char* name) {
  return reinterpret_cast<method>(dlsym(module, name));
}
#endif
} // namespace

std::string load_external(const std::string& file) {
  std::string reason;
  void* module = open_module(file, reason);
  if (!module)
    return reason;
  const method ext_main = find_function(module, "ext_main");
  if (!ext_main)
    return "it exports no ext_main";
  watch_module(module);
  const std::size_t before = classes().size();
  Call call{.where = Where::kLoad};
  run_external(call, [&] { ext_main(nullptr); });
  if (classes().size() == before)
    violation("ext_main of " + std::filesystem::path(file).filename().string() +
              " registered no class");
  return {};
}

} // namespace tactus::stub

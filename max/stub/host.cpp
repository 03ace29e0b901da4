// Loads externals, and reads the script from standard input.
#include "files/utf8_path.hpp"
#include "max/stub/stub.hpp"

#include <cstdio>
#include <iostream>

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace tactus::stub {
namespace {
#if defined(_WIN32)
std::string load(const std::string& file, method& ext_main) {
  // In Max, MaxAPI.dll and MaxAudio.dll are loaded before any external, wherever its file is.
  static const HMODULE audio = LoadLibraryW(L"MaxAudio.dll");
  const HMODULE module =
      audio ? LoadLibraryW(std::filesystem::absolute(utf8_path(file)).c_str()) : nullptr;
  if (!module)
    return "Windows' error " + std::to_string(GetLastError());
  ext_main =
      reinterpret_cast<method>(reinterpret_cast<void (*)()>(GetProcAddress(module, "ext_main")));
  return {};
}
#else
std::string load(const std::string& file, method& ext_main) {
  void* module = dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!module)
    return dlerror();
  ext_main = reinterpret_cast<method>(dlsym(module, "ext_main"));
  return {};
}
#endif

void run(std::istream& script) {
  std::vector<std::vector<std::string>> block; // the command "threads VECTORS" and the lines until
                                               // "end"
  for (std::string text; std::getline(script, text);) {
    std::vector<std::string> line = split_line(text);
    if (line.empty())
      continue;
    if (line[0] == "end") {
      run_threads(std::stoull(block.at(0).at(1)), std::span(block).subspan(1));
      block.clear();
    } else if (!block.empty() || line[0] == "threads")
      block.push_back(std::move(line));
    else
      execute(line);
  }
}
} // namespace

std::string load_external(const std::string& file) {
  method ext_main = nullptr;
  if (const std::string reason = load(file, ext_main); !reason.empty())
    return reason;
  if (!ext_main)
    return "it exports no ext_main";
  Call call{.where = Where::kLoad};
  run_external(call, [&] { ext_main(nullptr); });
  return {};
}

} // namespace tactus::stub

/// The host's main(). Returns 0, or 2 if the script is wrong, or 3 if there was a violation.
extern "C" int run_host();
extern "C" int run_host() {
  using namespace tactus::stub;
  set_role(kMain);
  try {
    run(std::cin);
    set_role(kMain);
    finish();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "script: %s\n", error.what());
    return 2;
  }
  return any_violation() ? 3 : 0;
}

#include "devices/shared_library.hpp"

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <vector>

#include <dlfcn.h>
#include <unistd.h>

namespace tactus::devices {
namespace {

/// The loader's search path for a bare name; empty if the system does not report it.
std::vector<std::string> search_folders() {
  std::vector<std::string> folders;
#ifdef __GLIBC__
  void* program = dlopen(nullptr, RTLD_LAZY);
  Dl_serinfo size{};
  if (!program || dlinfo(program, RTLD_DI_SERINFOSIZE, &size) != 0)
    return folders;
  std::vector<std::max_align_t> memory(size.dls_size / sizeof(std::max_align_t) + 1);
  auto* all = reinterpret_cast<Dl_serinfo*>(memory.data());
  if (dlinfo(program, RTLD_DI_SERINFOSIZE, all) != 0 || dlinfo(program, RTLD_DI_SERINFO, all) != 0)
    return folders;
  for (unsigned i = 0; i < all->dls_cnt; ++i)
    folders.emplace_back(all->dls_serpath[i].dls_name);
#endif
  return folders;
}

/// The file that a name resolves to; empty if there is none.
std::string file_of(const std::string& name) {
  if (name.find('/') != std::string::npos)
    return access(name.c_str(), F_OK) == 0 ? name : std::string();
  for (const std::string& folder : search_folders())
    if (const std::string path = folder + "/" + name; access(path.c_str(), F_OK) == 0)
      return path;
  return {};
}

/// Class, byte order and machine of an ELF file: bytes 4, 5, 18 and 19 (System V ABI, "ELF
/// Header").
std::array<char, 4> machine_of(const std::string& path) {
  std::array<char, 20> head{};
  std::ifstream(path, std::ios::binary).read(head.data(), head.size());
  return std::memcmp(head.data(), "\177ELF", 4) == 0
             ? std::array<char, 4>{head[4], head[5], head[18], head[19]}
             : std::array<char, 4>{};
}

/// The loader passes over a file that it may not read, and over one for another machine, as if it
/// were not there.
std::string why_passed_over(const std::string& path) {
  if (access(path.c_str(), R_OK) != 0)
    return path + " is not readable: change its permissions";
  Dl_info own{};
  if (dladdr(reinterpret_cast<const void*>(&std::getenv), &own) == 0 || !own.dli_fname)
    return path + " cannot be loaded";
  const auto machine = machine_of(path), ours = machine_of(own.dli_fname);
  if (machine == std::array<char, 4>{})
    return path + " is not a shared library";
  return machine != ours ? path + " is for another machine than this program (32 or 64 bits, or "
                                  "another processor)"
                         : path + " cannot be loaded";
}

} // namespace

void* SharedLibrary::open(const char* name, std::string& error, bool& missing) {
  void* handle = dlopen(name, RTLD_NOW | RTLD_LOCAL); // never closed
  if (handle)
    return handle;
  const char* reason = dlerror();
  error = reason ? reason : "cannot be loaded";
  // The loader says "NAME: ... No such file or directory"; NAME may also be a library that this one
  // needs.
  const std::string file = file_of(name);
  missing = file.empty();
  if (!missing && error.rfind(name, 0) == 0 &&
      error.find(std::strerror(ENOENT)) != std::string::npos)
    error = why_passed_over(file);
  return nullptr;
}

void* SharedLibrary::address(const char* symbol_name) const noexcept {
  return handle_ ? dlsym(handle_, symbol_name) : nullptr;
}

} // namespace tactus::devices

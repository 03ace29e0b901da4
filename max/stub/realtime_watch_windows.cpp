// A module's import table is rewritten: what it takes of the C library and the system goes through
// here.
#include "max/stub/kernel.hpp"
#include "max/stub/realtime_watch.hpp"

#include <array>
#include <cstdlib>
#include <windows.h>

namespace tactus::stub {
namespace {
void* watched_malloc(std::size_t size) {
  note_system_call("malloc", false);
  return std::malloc(size);
}
void* watched_calloc(std::size_t count, std::size_t size) {
  note_system_call("calloc", false);
  return std::calloc(count, size);
}
void* watched_realloc(void* memory, std::size_t size) {
  note_system_call("realloc", false);
  return std::realloc(memory, size);
}
void watched_free(void* memory) {
  if (memory)
    note_system_call("free", true);
  std::free(memory);
}
void WINAPI watched_sleep(DWORD ms) {
  note_system_call("Sleep", false);
  Sleep(ms);
}
void WINAPI watched_section(CRITICAL_SECTION* section) {
  note_system_call("EnterCriticalSection", false);
  EnterCriticalSection(section);
}
struct Replacement {
  std::string_view name;
  void* function;
};
const std::array replacements{
    Replacement{"malloc", reinterpret_cast<void*>(watched_malloc)},
    Replacement{"calloc", reinterpret_cast<void*>(watched_calloc)},
    Replacement{"realloc", reinterpret_cast<void*>(watched_realloc)},
    Replacement{"free", reinterpret_cast<void*>(watched_free)},
    Replacement{"Sleep", reinterpret_cast<void*>(watched_sleep)},
    Replacement{"EnterCriticalSection", reinterpret_cast<void*>(watched_section)}};

void replace(IMAGE_THUNK_DATA& slot, std::string_view name) {
  for (const Replacement& r : replacements)
    if (r.name == name) {
      DWORD before = 0;
      VirtualProtect(&slot, sizeof slot, PAGE_READWRITE, &before);
      slot.u1.Function = reinterpret_cast<ULONGLONG>(r.function);
      VirtualProtect(&slot, sizeof slot, before, &before);
    }
}
} // namespace

void install_realtime_watch() {}

void watch_module(void* module) {
  auto* base = static_cast<std::byte*>(module);
  const auto* dos = reinterpret_cast<const IMAGE_DOS_HEADER*>(base);
  const auto* headers = reinterpret_cast<const IMAGE_NT_HEADERS64*>(base + dos->e_lfanew);
  const IMAGE_DATA_DIRECTORY& imports =
      headers->OptionalHeader.DataDirectory[IMAGE_DIRECTORY_ENTRY_IMPORT];
  if (imports.VirtualAddress == 0)
    return;
  const auto* library =
      reinterpret_cast<const IMAGE_IMPORT_DESCRIPTOR*>(base + imports.VirtualAddress);
  for (; library->Name != 0; ++library) {
    const auto* names =
        reinterpret_cast<const IMAGE_THUNK_DATA*>(base + library->OriginalFirstThunk);
    auto* slots = reinterpret_cast<IMAGE_THUNK_DATA*>(base + library->FirstThunk);
    for (; names->u1.AddressOfData != 0; ++names, ++slots)
      if ((names->u1.Ordinal & IMAGE_ORDINAL_FLAG64) == 0) {
        const auto* by_name =
            reinterpret_cast<const IMAGE_IMPORT_BY_NAME*>(base + names->u1.AddressOfData);
        replace(*slots, reinterpret_cast<const char*>(by_name->Name));
      }
  }
}

} // namespace tactus::stub

// Guard pages, on POSIX by mprotect and SIGSEGV, on Windows by VirtualProtect and a vectored
// handler.
#include "max/stub/guarded.hpp"

#include "max/stub/kernel.hpp"

#include <array>
#include <cstdlib>
#include <cstring>

#if defined(_WIN32)
#include <windows.h>
#else
#include <csignal>
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace tactus::stub {
namespace {
constexpr std::size_t kPage = 4096;
constexpr std::byte kFront{0x5C};

std::byte* map_pages(std::size_t bytes) {
#if defined(_WIN32)
  void* memory = VirtualAlloc(nullptr, bytes, MEM_RESERVE | MEM_COMMIT, PAGE_READWRITE);
#else
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED)
    memory = nullptr;
#endif
  if (!memory)
    std::abort();
  return static_cast<std::byte*>(memory);
}
void unmap_pages(std::byte* memory, std::size_t bytes) {
#if defined(_WIN32)
  static_cast<void>(bytes);
  VirtualFree(memory, 0, MEM_RELEASE);
#else
  munmap(memory, bytes);
#endif
}
void set_access(std::byte* memory, std::size_t bytes, bool allowed) {
#if defined(_WIN32)
  DWORD before = 0;
  VirtualProtect(memory, bytes, allowed ? PAGE_READWRITE : PAGE_NOACCESS, &before);
#else
  mprotect(memory, bytes, allowed ? PROT_READ | PROT_WRITE : PROT_NONE);
#endif
}

/// What the handler looks a forbidden address up in.
struct Range {
  std::atomic<std::byte*> begin{nullptr};
  std::size_t bytes = 0;
  std::string what{};
};
std::array<Range, 4096> ranges;

std::size_t add_range(std::byte* begin, std::size_t bytes, const std::string& what) {
  for (std::size_t i = 0; i < ranges.size(); ++i)
    if (!ranges[i].begin.load()) {
      ranges[i].bytes = bytes;
      ranges[i].what = what;
      ranges[i].begin = begin;
      return i;
    }
  std::abort();
}

/// Whether the fault was at a forbidden address; then it is reported, and the memory opens.
bool handle_fault(void* address, const char* access) {
  const auto* byte = static_cast<std::byte*>(address);
  for (Range& range : ranges) {
    std::byte* begin = range.begin.load();
    if (!begin || byte < begin || byte >= begin + range.bytes)
      continue;
    const HostWork work;
    set_access(begin, range.bytes, true);
    violation(std::string(access) + " " + range.what);
    return true;
  }
  const HostWork work;
  violation("a crash at address " + std::to_string(reinterpret_cast<std::uintptr_t>(address)));
  return false;
}

#if defined(_WIN32)
LONG CALLBACK on_exception(EXCEPTION_POINTERS* exception) {
  const EXCEPTION_RECORD& record = *exception->ExceptionRecord;
  if (record.ExceptionCode != EXCEPTION_ACCESS_VIOLATION)
    return EXCEPTION_CONTINUE_SEARCH;
  if (handle_fault(reinterpret_cast<void*>(record.ExceptionInformation[1]),
                   record.ExceptionInformation[0] ? "write to" : "read of"))
    return EXCEPTION_CONTINUE_EXECUTION;
  TerminateProcess(GetCurrentProcess(), 4);
  return EXCEPTION_CONTINUE_SEARCH;
}
#else
void on_signal(int, siginfo_t* information, void*) {
  if (!handle_fault(information->si_addr, "access to"))
    _exit(4);
}
#endif
} // namespace

void install_fault_handler() {
#if defined(_WIN32)
  AddVectoredExceptionHandler(1, on_exception);
#else
  struct sigaction action {};
  action.sa_sigaction = on_signal;
  action.sa_flags = SA_SIGINFO | SA_NODEFER;
  sigaction(SIGSEGV, &action, nullptr);
  sigaction(SIGBUS, &action, nullptr);
#endif
}

ForbiddenPages::ForbiddenPages(const std::string& what) : memory_(map_pages(kPage)) {
  auto* doubles = static_cast<double*>(memory_);
  for (std::size_t i = 0; i < kPage / sizeof(double); ++i)
    doubles[i] = 0;
  slot_ = add_range(static_cast<std::byte*>(memory_), kPage, what);
  set_access(static_cast<std::byte*>(memory_), kPage, false);
}
ForbiddenPages::~ForbiddenPages() {
  ranges[slot_].begin = nullptr;
  unmap_pages(static_cast<std::byte*>(memory_), kPage);
}

GuardedVector::GuardedVector(std::size_t count, const std::string& what)
    : count_(count), bytes_(count * sizeof(double)),
      open_bytes_((bytes_ + 64 + kPage - 1) / kPage * kPage),
      memory_(map_pages(open_bytes_ + kPage)),
      data_(reinterpret_cast<double*>(memory_ + open_bytes_ - bytes_)) {
  std::memset(memory_, static_cast<int>(kFront), open_bytes_ - bytes_);
  std::memset(data_, 0, bytes_);
  end_slot_ = add_range(memory_ + open_bytes_, kPage, "memory beyond the end of " + what);
  set_access(memory_ + open_bytes_, kPage, false);
  slot_ = add_range(memory_, 0, what + ", which is not connected");
}
GuardedVector::~GuardedVector() {
  ranges[slot_].begin = nullptr;
  ranges[end_slot_].begin = nullptr;
  unmap_pages(memory_, open_bytes_ + kPage);
}

bool GuardedVector::front_intact() const noexcept {
  if (forbidden_)
    return true;
  for (const std::byte* byte = memory_; byte < reinterpret_cast<std::byte*>(data_); ++byte)
    if (*byte != kFront)
      return false;
  return true;
}

void GuardedVector::forbid(bool forbidden) noexcept {
  ranges[slot_].bytes = forbidden ? open_bytes_ : 0;
  set_access(memory_, open_bytes_, !forbidden);
  forbidden_ = forbidden;
}

} // namespace tactus::stub

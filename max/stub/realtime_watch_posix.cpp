// By interposition: this program's own malloc and others stand before the C library's. Under a
// sanitizer, which does so itself, by its hooks: then locks and system calls are not watched.
#include "max/stub/kernel.hpp"
#include "max/stub/realtime_watch.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define STUB_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define STUB_SANITIZER 1
#endif
#endif

#if defined(STUB_SANITIZER)
#include <cstddef>

// NOLINTBEGIN(bugprone-reserved-identifier): a name of the sanitizers' library
// Of <sanitizer/allocator_interface.h>, which g++ does not bring along.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*)(const volatile void*,
                                                                  std::size_t),
                                                         void (*)(const volatile void*));
// NOLINTEND(bugprone-reserved-identifier)

namespace tactus::stub {
void install_realtime_watch() {
  __sanitizer_install_malloc_and_free_hooks(
      [](const volatile void*, std::size_t) { note_system_call("malloc", false); },
      [](const volatile void*) { note_system_call("free", true); });
}
void watch_module(void*) {}
} // namespace tactus::stub

#else
#include <cerrno>
#include <cstdlib>
#include <ctime>
#include <dlfcn.h>
#include <pthread.h>
#include <unistd.h>

#define INTERPOSED extern "C" __attribute__((visibility("default")))

// NOLINTBEGIN(bugprone-reserved-identifier): names of the C library
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
}
// NOLINTEND(bugprone-reserved-identifier)

namespace tactus::stub {
namespace {
template <class Function> Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}
using Lock = int (*)(pthread_mutex_t*);
using Write = ssize_t (*)(int, const void*, std::size_t);
using Sleep = int (*)(const timespec*, timespec*);
const Lock real_lock = next<Lock>("pthread_mutex_lock");
const Write real_write = next<Write>("write");
const Sleep real_sleep = next<Sleep>("nanosleep");
} // namespace
void install_realtime_watch() {}
void watch_module(void*) {}
} // namespace tactus::stub

using namespace tactus::stub;

INTERPOSED void* malloc(std::size_t size) noexcept {
  note_system_call("malloc", false);
  return __libc_malloc(size);
}
INTERPOSED void* calloc(std::size_t count, std::size_t size) noexcept {
  note_system_call("calloc", false);
  return __libc_calloc(count, size);
}
INTERPOSED void* realloc(void* memory, std::size_t size) noexcept {
  note_system_call("realloc", false);
  return __libc_realloc(memory, size);
}
INTERPOSED void free(void* memory) noexcept {
  if (memory)
    note_system_call("free", true);
  __libc_free(memory);
}
INTERPOSED void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  note_system_call("aligned_alloc", false);
  return __libc_memalign(alignment, size);
}
INTERPOSED int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  note_system_call("posix_memalign", false);
  *memory = __libc_memalign(alignment, size);
  return *memory ? 0 : ENOMEM;
}
INTERPOSED int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  note_system_call("pthread_mutex_lock", false);
  // Before this program's own initialisation there is one thread.
  return real_lock ? real_lock(mutex) : 0;
}
INTERPOSED ssize_t write(int file, const void* bytes, std::size_t count) {
  note_system_call("write", false);
  return real_write ? real_write(file, bytes, count) : 0;
}
INTERPOSED int nanosleep(const timespec* wanted, timespec* left) {
  note_system_call("nanosleep", false);
  return real_sleep(wanted, left);
}
#endif

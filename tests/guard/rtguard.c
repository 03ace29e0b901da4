/* Preloaded into a host: fails it when its audio code allocates, frees, locks or makes a system
   call. The Pd shell brackets every process() by rtguard_set(1) and rtguard_set(0).

   Two nets: library calls are replaced by counting ones (malloc and an uncontended mutex need no
   system call), and where the kernel offers it (Linux 5.11, x86-64 here) every system call of the
   guarded thread is trapped, whoever makes it. Also reports a changed floating-point mode.
   At the end prints what it saw; exit status 86 when there was a violation. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
#if defined(__x86_64__)
#include <ucontext.h>
#include <xmmintrin.h>
#endif

#pragma GCC diagnostic ignored "-Wpedantic" /* functions from dlsym */

static __thread int guarded;
static __thread char trap_selector; /* 0: system calls pass, 1: they are trapped */
static __thread int trap_armed;
static __thread unsigned mode_before;
static int violations, guarded_calls, trapping;

void rtguard_set(int on);

static void seen(const char* what) {
  guarded = 0;
  trap_selector = 0;
  const int count = __atomic_add_fetch(&violations, 1, __ATOMIC_RELAXED);
  if (count <= 5) {
    fprintf(stderr, "rtguard: %s on the audio path\n", what);
    void* frames[24];
    backtrace_symbols_fd(frames, backtrace(frames, 24), 2);
  }
}

/* After a violation the rest of the block passes unwatched: it has failed already. */
#define WATCH(what)                                                                                \
  if (guarded)                                                                                     \
  seen(what)

#if defined(__x86_64__) && defined(PR_SET_SYSCALL_USER_DISPATCH)
static void on_trap(int signal, siginfo_t* info, void* context) {
  (void)signal;
  char text[64];
  snprintf(text, sizeof text, "system call %d", info->si_syscall);
  seen(text);
  greg_t* r = ((ucontext_t*)context)->uc_mcontext.gregs;
  const long result = syscall(info->si_syscall, r[REG_RDI], r[REG_RSI], r[REG_RDX], r[REG_R10],
                              r[REG_R8], r[REG_R9]);
  r[REG_RAX] = result < 0 ? -errno : result;
}

static void arm_trap(void) {
  trap_armed = 1;
  struct sigaction action = {.sa_sigaction = on_trap, .sa_flags = SA_SIGINFO | SA_NODEFER};
  if (sigaction(SIGSYS, &action, 0))
    return;
  trapping = !prctl(PR_SET_SYSCALL_USER_DISPATCH, PR_SYS_DISPATCH_ON, 0, 0, &trap_selector);
}
#else
static void arm_trap(void) { trap_armed = 1; }
#endif

static unsigned float_mode(void) {
#if defined(__x86_64__)
  return _mm_getcsr() & ~0x3fu; /* without the sticky exception flags */
#else
  return 0;
#endif
}

void rtguard_set(int on) {
  if (on) {
    if (!trap_armed)
      arm_trap();
    __atomic_add_fetch(&guarded_calls, 1, __ATOMIC_RELAXED);
    mode_before = float_mode();
    guarded = 1;
    trap_selector = 1;
  } else {
    trap_selector = 0;
    if (guarded && float_mode() != mode_before)
      seen("a changed floating-point mode");
    guarded = 0;
  }
}

extern void* __libc_malloc(size_t);
extern void __libc_free(void*);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_memalign(size_t, size_t);
#define COUNTED(result, name, parameters, ...)                                                     \
  result name parameters {                                                                         \
    WATCH(#name);                                                                                  \
    __VA_ARGS__;                                                                                   \
  }
COUNTED(void*, malloc, (size_t n), return __libc_malloc(n))
COUNTED(void, free, (void* p), __libc_free(p))
COUNTED(void*, realloc, (void* p, size_t n), return __libc_realloc(p, n))
COUNTED(void*, calloc, (size_t count, size_t size), return __libc_calloc(count, size))
COUNTED(void*, aligned_alloc, (size_t alignment, size_t n), return __libc_memalign(alignment, n))
COUNTED(void*, memalign, (size_t alignment, size_t n), return __libc_memalign(alignment, n))
COUNTED(int, posix_memalign, (void** p, size_t alignment, size_t n),
        *p = __libc_memalign(alignment, n);
        return *p ? 0 : ENOMEM)

/* Calls that only sometimes enter the kernel. */
#define REPLACE(result, name, parameters, arguments)                                               \
  result name parameters;                                                                          \
  result name parameters {                                                                         \
    static result(*real) parameters;                                                               \
    WATCH(#name);                                                                                  \
    if (!real)                                                                                     \
      real = dlsym(RTLD_NEXT, #name);                                                              \
    return real arguments;                                                                         \
  }
REPLACE(int, pthread_mutex_lock, (pthread_mutex_t * m), (m))
REPLACE(int, pthread_mutex_trylock, (pthread_mutex_t * m), (m))
REPLACE(int, pthread_mutex_unlock, (pthread_mutex_t * m), (m))
REPLACE(int, pthread_mutex_timedlock, (pthread_mutex_t * m, const struct timespec* t), (m, t))
REPLACE(int, pthread_rwlock_rdlock, (pthread_rwlock_t * l), (l))
REPLACE(int, pthread_rwlock_wrlock, (pthread_rwlock_t * l), (l))
REPLACE(int, pthread_spin_lock, (pthread_spinlock_t * l), (l))
REPLACE(int, pthread_cond_wait, (pthread_cond_t * c, pthread_mutex_t* m), (c, m))
REPLACE(int, pthread_cond_signal, (pthread_cond_t * c), (c))
REPLACE(int, pthread_cond_broadcast, (pthread_cond_t * c), (c))
REPLACE(int, sem_wait, (sem_t * s), (s))
REPLACE(int, sem_post, (sem_t * s), (s))
/* Blocking calls, by name where the kernel cannot trap them. */
REPLACE(ssize_t, write, (int file, const void* from, size_t n), (file, from, n))
REPLACE(ssize_t, read, (int file, void* to, size_t n), (file, to, n))
REPLACE(int, nanosleep, (const struct timespec* t, struct timespec* left), (t, left))
REPLACE(int, clock_nanosleep,
        (clockid_t c, int flags, const struct timespec* t, struct timespec* left),
        (c, flags, t, left))
REPLACE(int, usleep, (useconds_t us), (us))
REPLACE(FILE*, fopen, (const char* path, const char* mode), (path, mode))
REPLACE(void*, dlopen, (const char* path, int flags), (path, flags))

static void __attribute__((destructor)) report(void) {
  guarded = 0;
  fprintf(stderr, "rtguard: %d violations in %d guarded calls, system calls %s\n", violations,
          guarded_calls, trapping ? "trapped" : "watched by name");
  fflush(stderr);
  if (violations)
    _exit(86);
}

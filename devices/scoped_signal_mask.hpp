#pragma once

#ifndef _WIN32
#include <csignal>
#endif

namespace tactus::devices {

/// Blocks signals in the calling thread while the object lives; threads started meanwhile inherit
/// the mask for good. A host's termination handler must not run in the servo's thread: it would
/// wait for that thread to end, and the last force would stay. Synchronous faults (SIGSEGV, SIGBUS,
/// SIGFPE, SIGILL, SIGABRT, SIGTRAP) stay unblocked.
class ScopedSignalMask {
public:
#ifndef _WIN32
  ScopedSignalMask() noexcept {
    sigset_t mask;
    sigfillset(&mask);
    for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP})
      sigdelset(&mask, fault);
    pthread_sigmask(SIG_BLOCK, &mask, &previous_mask_);
  }
  ~ScopedSignalMask() { pthread_sigmask(SIG_SETMASK, &previous_mask_, nullptr); }
#else
  ScopedSignalMask() noexcept {}
  ~ScopedSignalMask() {}
#endif
  ScopedSignalMask(const ScopedSignalMask&) = delete;
  ScopedSignalMask& operator=(const ScopedSignalMask&) = delete;

private:
#ifndef _WIN32
  sigset_t previous_mask_{};
#endif
};

} // namespace tactus::devices

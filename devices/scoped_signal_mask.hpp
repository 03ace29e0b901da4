#pragma once

#ifndef _WIN32
#include <csignal>
#endif

namespace tactus::devices {

/// While this lives, the calling thread takes no signal, and threads that it starts never will, nor
/// those that they start. A host's handler for the end of its program must run in the host's own
/// thread: in a servo's it would wait for itself, and the last force would stay. Faults of a
/// thread's own (SIGSEGV and its like) are not held back.
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

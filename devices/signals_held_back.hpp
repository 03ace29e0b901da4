#pragma once

#ifndef _WIN32
#include <csignal>
#endif

namespace tactus::devices {

/// While this lives, the calling thread takes no signal, and threads that it starts never will, nor
/// those that they start. A host's handler for the end of its program must run in the host's own
/// thread: in a servo's it would wait for itself, and the last force would stay. Faults of a
/// thread's own (SIGSEGV and its like) are not held back.
class SignalsHeldBack {
public:
#ifndef _WIN32
  SignalsHeldBack() noexcept {
    sigset_t held;
    sigfillset(&held);
    for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP})
      sigdelset(&held, fault);
    pthread_sigmask(SIG_BLOCK, &held, &before_);
  }
  ~SignalsHeldBack() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
#else
  SignalsHeldBack() noexcept {}
  ~SignalsHeldBack() {}
#endif
  SignalsHeldBack(const SignalsHeldBack&) = delete;
  SignalsHeldBack& operator=(const SignalsHeldBack&) = delete;

private:
#ifndef _WIN32
  sigset_t before_{};
#endif
};

} // namespace tactus::devices

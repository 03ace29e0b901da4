#pragma once

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#include <sched.h>
#endif

namespace tactus {

/// A thread is born with its parent's priority, which may be that of the audio; one that computes
/// in the background gives it up.
inline void set_normal_priority() noexcept {
#if defined(__unix__) || defined(__APPLE__)
  sched_param normal_priority{};
  (void)pthread_setschedparam(pthread_self(), SCHED_OTHER, &normal_priority);
#endif
}

} // namespace tactus

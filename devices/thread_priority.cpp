#include "devices/thread_priority.hpp"

#ifdef __linux__
#include <pthread.h>
#include <sched.h>
#endif

namespace tactus::devices {

void raise_thread_priority(int priority) noexcept {
#ifdef __linux__
  sched_param parameters{};
  parameters.sched_priority = priority;
  static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters));
#else
  static_cast<void>(priority);
#endif
}

} // namespace tactus::devices

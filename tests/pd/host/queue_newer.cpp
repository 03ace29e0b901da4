// What Pd 0.54 to 0.57 add: multichannel signals and posting from threads. Built for many
// instances, as libpd's MULTI is: each thread has its own.
#include "tests/pd/host/internal.hpp"

#include <list>
#include <mutex>

#undef pd_this

namespace {

t_pdinstance instance_of_thread;
using Function = void (*)(t_pd*, void*);
struct Entry {
  t_pd* object;
  void* argument;
  Function function;
};
std::mutex lock;
std::list<Entry> queue;

} // namespace

extern "C" {
#ifndef _WIN32 // a DLL exports none
thread_local t_pdinstance* pd_this = &instance_of_thread;
#endif
void signal_setmultiout(t_signal** signal, int channels);
void pd_queue_mess(t_pdinstance* instance, t_pd* object, void* argument, Function function);
void pd_queue_cancel(t_pd* object);
}

void signal_setmultiout(t_signal** signal, int channels) {
  reinterpret_cast<tactus::test::HostSignal*>(*signal)->set_channels(channels);
}

void pd_queue_mess(t_pdinstance* instance, t_pd* object, void* argument, Function function) {
#ifdef _WIN32
  if (instance != &pd_maininstance)
#else
  if (instance != &instance_of_thread)
#endif
    tactus::test::die("pd_queue_mess for another instance");
  const std::lock_guard held(lock);
  queue.push_back({object, argument, function});
}

void pd_queue_cancel(t_pd* object) {
  const std::lock_guard held(lock);
  for (Entry& entry : queue)
    if (entry.object == object)
      entry.object = nullptr;
}

bool tactus::test::is_newer() { return true; }
void tactus::test::deliver_queue() {
  std::unique_lock held(lock);
  while (!queue.empty()) {
    const Entry entry = queue.front();
    queue.pop_front();
    held.unlock();
    entry.function(entry.object, entry.argument); // with a null object when cancelled, as Pd does
    held.lock();
  }
}

// Logical time: clocks, the low-priority queue, critical regions.
#include "max/stub/audio.hpp"
#include "max/stub/kernel.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

namespace tactus::stub {
namespace {
struct Clock : Record {
  static constexpr Kind kKind = Kind::kClock;
  Clock() : Record(kKind) {}
  void* argument = nullptr;
  method function = nullptr;
  bool armed = false;
  double due_ms = 0;
  std::uint64_t order = 0;
};
struct Qelem : Record {
  static constexpr Kind kKind = Kind::kQelem;
  Qelem() : Record(kKind) {}
  void* argument = nullptr;
  method function = nullptr;
  std::atomic<bool> set{false};
};
std::mutex scheduler_mutex; // of armed and waiting
std::vector<Clock*> armed;
std::deque<Qelem*> waiting;
std::atomic<double> time_ms{0};
std::atomic<bool> overdrive{true};
std::uint64_t next_order = 0;
constinit thread_local double due_time = -1; // of the clock that runs, else < 0
std::recursive_mutex& global_region() {
  static std::recursive_mutex mutex;
  return mutex;
}

void disarm(Clock& clock) {
  clock.armed = false;
  std::erase(armed, &clock);
}
void callback(Record& record, method function, void* argument, std::string_view name) {
  if (const Record* target = find_record(argument); target && !target->alive) {
    violation(std::string(name) + ": its object was freed");
    return;
  }
  Call call{.where = Where::kCallback, .object = record.owner, .name = name};
  run_external(call, [&] { function(argument); });
}
} // namespace

double now_ms() { return due_time >= 0 ? due_time : time_ms.load(std::memory_order_relaxed); }
void set_overdrive(bool on) { overdrive = on; }
Role scheduler_role() { return overdrive ? Role::kScheduler : Role::kMain; }

void advance_clocks(double until_ms) {
  const Role before = current_role();
  set_role(scheduler_role());
  for (;;) {
    Clock* next = nullptr;
    {
      const std::lock_guard lock(scheduler_mutex);
      for (Clock* c : armed)
        if (c->due_ms <= until_ms &&
            (!next || std::pair(c->due_ms, c->order) < std::pair(next->due_ms, next->order)))
          next = c;
      if (next) {
        disarm(*next);
        due_time = std::max(next->due_ms, time_ms.load(std::memory_order_relaxed));
      }
    }
    if (!next)
      break;
    callback(*next, next->function, next->argument, "clock");
    due_time = -1;
  }
  set_role(before);
  double old = time_ms.load(std::memory_order_relaxed);
  while (old < until_ms &&
         !time_ms.compare_exchange_weak(old, until_ms, std::memory_order_relaxed)) {
  }
}

void run_low_priority() {
  for (std::size_t left = 1000; left > 0;
       --left) { // one that sets itself again must not stop the host
    Qelem* next = nullptr;
    {
      const std::lock_guard lock(scheduler_mutex);
      if (waiting.empty())
        return;
      next = waiting.front();
      waiting.pop_front();
    }
    next->set.store(false);
    if (!next->alive)
      continue;
    const Role before = current_role();
    set_role(Role::kMain); // the queue is the main thread's, whose turn is now
    callback(*next, next->function, next->argument, "qelem");
    set_role(before);
  }
}

void free_clock(Record& record) {
  auto& clock = static_cast<Clock&>(record);
  const std::lock_guard lock(scheduler_mutex);
  if (clock.armed)
    violation("object_free: a clock that is armed: call clock_unset first");
  disarm(clock);
  clock.alive = false;
}

void forget_owner(const Object& object) {
  const std::lock_guard lock(scheduler_mutex);
  std::erase_if(armed, [&](const Clock* c) { return c->owner == &object; });
  std::erase_if(waiting, [&](const Qelem* q) { return q->owner == &object; });
}

} // namespace tactus::stub

using namespace tactus::stub;

namespace {
constexpr unsigned kClockThreads = kMessageThreads | static_cast<unsigned>(Role::kAudio);
template <class Timer> Timer* make_timer(void* argument, method function, const char* name) {
  auto* timer = new Timer;
  add_record(timer, timer);
  if (!function)
    violation(std::string(name) + ": no function");
  timer->argument = argument;
  timer->function = function;
  return timer;
}
} // namespace

void* clock_new(void* argument, method function) {
  const ApiCall api("clock_new", static_cast<unsigned>(Role::kMain));
  return make_timer<Clock>(argument, function, "clock_new");
}
void clock_fdelay(void* address, double ms) {
  const ApiCall api("clock_fdelay", kClockThreads);
  auto* clock = require<Clock>(address, "clock_fdelay");
  if (!clock)
    return;
  if (!std::isfinite(ms) || ms < 0)
    violation("clock_fdelay: a delay of " + std::to_string(ms) + " ms");
  const std::lock_guard lock(scheduler_mutex);
  disarm(*clock);
  clock->armed = true;
  clock->due_ms = now_ms() + (std::isfinite(ms) ? std::max(ms, 0.0) : 0.0);
  clock->order = next_order++;
  armed.push_back(clock);
}
void clock_unset(void* address) {
  const ApiCall api("clock_unset", kClockThreads);
  auto* clock = require<Clock>(address, "clock_unset");
  if (!clock)
    return;
  const std::lock_guard lock(scheduler_mutex);
  disarm(*clock);
}
void clock_getftime(double* ms) {
  const ApiCall api("clock_getftime", kAnyThread);
  if (!ms)
    violation("clock_getftime: null");
  else
    *ms = now_ms();
}

void* qelem_new(void* argument, method function) {
  const ApiCall api("qelem_new", static_cast<unsigned>(Role::kMain));
  return make_timer<Qelem>(argument, function, "qelem_new");
}
void qelem_set(void* address) {
  const ApiCall api("qelem_set", kAnyThread);
  auto* element = require<Qelem>(address, "qelem_set");
  if (!element || element->set.exchange(true))
    return;
  const std::lock_guard lock(scheduler_mutex);
  waiting.push_back(element);
}
void qelem_free(void* address) {
  const ApiCall api("qelem_free");
  if (const Record* record = find_record(address);
      record && record->kind == Kind::kQelem && !record->alive) {
    violation("qelem_free: double free of qelem");
    return;
  }
  auto* element = require<Qelem>(address, "qelem_free");
  if (!element)
    return;
  const std::lock_guard lock(scheduler_mutex);
  std::erase(waiting, element);
  element->alive = false;
}

short systhread_ismainthread() {
  const ApiCall api("systhread_ismainthread", kAnyThread);
  return current_role() == Role::kMain;
}

void critical_enter(t_critical region) {
  const ApiCall api("critical_enter");
  if (region)
    violation("critical_enter: a region that is not from critical_new");
  if (Call* call = current_call())
    ++call->critical;
  global_region().lock();
}
void critical_exit(t_critical region) {
  const ApiCall api("critical_exit");
  if (region)
    violation("critical_exit: a region that is not from critical_new");
  Call* call = current_call();
  if (!call || call->critical == 0) {
    violation("critical_exit without critical_enter");
    return;
  }
  --call->critical;
  global_region().unlock();
}

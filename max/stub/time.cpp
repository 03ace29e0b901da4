// Logical time: clocks, the low-priority queue, critical regions.
#include "max/stub/stub.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>

namespace tactus::stub {
namespace {
struct Timer : Record {
  using Record::Record;
  void* argument = nullptr;
  method function = nullptr;
  double due_ms = 0; ///< time at which a clock is due
  void run() const {
    Call call{.where = Where::kClock, .object = owner};
    run_external(call, [&] { function(argument); });
  }
};
struct Clock : Timer {
  static constexpr Kind kKind = Kind::kClock;
  Clock() : Timer(kKind) {}
};
struct Qelem : Timer {
  static constexpr Kind kKind = Kind::kQelem;
  Qelem() : Timer(kKind) {}
  std::atomic<bool> set{false};
};
std::mutex timers_mutex;
std::vector<Clock*> armed; // in the order in which they were set
std::deque<Qelem*> waiting;
std::atomic<double> time_ms{0};
constinit thread_local double due_time = -1; // due time of the running clock, else below 0
std::recursive_mutex critical_region;

template <class T> T* make_timer(const char* name, void* argument, method function) {
  const ApiCall api(name, kMain);
  auto* timer = new T;
  keep(*timer);
  timer->argument = argument;
  timer->function = function;
  return timer;
}
/// Removes the clock that is due first from `armed`, and returns it with its due time in ms.
std::pair<const Clock*, double> next_due(double until_ms) {
  const std::lock_guard lock(timers_mutex);
  const auto next =
      std::min_element(armed.begin(), armed.end(),
                       [](const Clock* a, const Clock* b) { return a->due_ms < b->due_ms; });
  if (next == armed.end() || (*next)->due_ms > until_ms)
    return {nullptr, 0};
  const std::pair<const Clock*, double> found{*next, (*next)->due_ms};
  armed.erase(next);
  return found;
}
Qelem* next_waiting() {
  const std::lock_guard lock(timers_mutex);
  if (waiting.empty())
    return nullptr;
  Qelem* next = waiting.front();
  waiting.pop_front();
  next->set = false;
  return next;
}
} // namespace

double now_ms() { return due_time >= 0 ? due_time : time_ms.load(std::memory_order_relaxed); }

void advance_clocks(double until_ms) {
  const Role before = current_role();
  set_role(kScheduler);
  for (auto next = next_due(until_ms); next.first; next = next_due(until_ms)) {
    due_time = std::max(next.second, time_ms.load(std::memory_order_relaxed));
    next.first->run();
    due_time = -1;
  }
  set_role(before);
  time_ms.store(std::max(until_ms, time_ms.load(std::memory_order_relaxed)),
                std::memory_order_relaxed);
}

void run_low_priority() {
  const Role before = current_role();
  set_role(kMain);
  for (int left = 1000; left > 0; --left) // a clock that sets itself again must not stop the host
    if (const Qelem* next = next_waiting())
      next->run();
  set_role(before);
}

void free_clock(Record& clock) {
  const std::lock_guard lock(timers_mutex);
  if (std::erase(armed, static_cast<Clock*>(&clock)) > 0)
    violation("object_free: a clock that is armed: call clock_unset first");
}
void forget_timers(const Object& object) {
  const std::lock_guard lock(timers_mutex);
  std::erase_if(armed, [&](const Clock* c) { return c->owner == &object; });
  std::erase_if(waiting, [&](const Qelem* q) { return q->owner == &object; });
}

} // namespace tactus::stub

using namespace tactus::stub;

void* clock_new(void* argument, method function) {
  return make_timer<Clock>("clock_new", argument, function);
}
void clock_fdelay(void* address, double ms) {
  const ApiCall api("clock_fdelay", kMessageThreads | kAudio);
  auto* clock = require<Clock>(address, "clock_fdelay");
  if (!clock)
    return;
  if (!std::isfinite(ms) || ms < 0)
    violation("clock_fdelay: a delay of " + std::to_string(ms) + " ms");
  const std::lock_guard lock(timers_mutex);
  std::erase(armed, clock);
  clock->due_ms = now_ms() + ms;
  armed.push_back(clock);
}
void clock_unset(void* address) {
  const ApiCall api("clock_unset", kMessageThreads | kAudio);
  const auto* clock = require<Clock>(address, "clock_unset");
  const std::lock_guard lock(timers_mutex);
  std::erase(armed, clock);
}
void clock_getftime(double* ms) {
  const ApiCall api("clock_getftime", kAnyThread);
  *ms = now_ms();
}

void* qelem_new(void* argument, method function) {
  return make_timer<Qelem>("qelem_new", argument, function);
}
void qelem_set(void* address) {
  const ApiCall api("qelem_set", kAnyThread);
  auto* element = require<Qelem>(address, "qelem_set");
  if (!element || element->set.exchange(true))
    return;
  const std::lock_guard lock(timers_mutex);
  waiting.push_back(element);
}
void qelem_free(void* address) {
  const ApiCall api("qelem_free");
  auto* element = require<Qelem>(address, "qelem_free");
  if (!element)
    return;
  const std::lock_guard lock(timers_mutex);
  std::erase(waiting, element);
  element->alive = false;
}

short systhread_ismainthread() { return current_role() == kMain; }

void critical_enter(t_critical) {
  const ApiCall api("critical_enter");
  if (Call* call = current_call())
    ++call->held;
  critical_region.lock();
}
void critical_exit(t_critical) {
  const ApiCall api("critical_exit");
  if (Call* call = current_call())
    --call->held;
  critical_region.unlock();
}

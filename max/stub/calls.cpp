// Tracks which external's function each thread executes, and prints the reports.
#include "max/stub/stub.hpp"

#include <cstdio>
#include <mutex>
#include <set>
#include <utility>

#if !defined(_WIN32)
#include <dlfcn.h>
#endif

namespace tactus::stub {
namespace {
constinit thread_local Role role = kForeign;
constinit thread_local Call* innermost = nullptr;
constinit thread_local int depth = 0; // above 0 in the stub, 0 in an external
constinit thread_local std::vector<std::string>* collected = nullptr;
std::mutex report_mutex;
std::set<std::string>& reported() {
  static std::set<std::string> texts;
  return texts;
}

constexpr const char* kPlaces[]{"ext_main", "constructor", "free method", "message", "attribute",
                                "assist",   "dsp64",       "perform",     "clock"};

/// If tests/guard is preloaded, it watches perform from a call with 1 to a call with 0.
using Guard = void (*)(int);
#if defined(_WIN32)
constexpr Guard guard = nullptr;
#else
const Guard guard = reinterpret_cast<Guard>(dlsym(RTLD_DEFAULT, "rtguard_set"));
#endif
void watch_perform(int on) noexcept {
  if (guard && innermost && innermost->where == Where::kPerform)
    guard(on);
}

/// Marks the stub's own work, so that it does not count as the external's.
struct HostWork {
  HostWork() noexcept {
    if (depth++ == 0)
      watch_perform(0);
  }
  ~HostWork() {
    if (--depth == 0)
      watch_perform(1);
  }
  HostWork(const HostWork&) = delete;
  HostWork& operator=(const HostWork&) = delete;
};

void print(const std::string& line) {
  std::fprintf(stdout, "%s\n", line.c_str());
  std::fflush(stdout);
}
} // namespace

void collect_lines(std::vector<std::string>* lines) { collected = lines; }

void print_line(const std::string& line) {
  const HostWork work;
  if (collected)
    collected->push_back(line);
  else
    print(line);
}

void violation(const std::string& text) {
  const HostWork work;
  std::string line = "violation: " + text;
  if (innermost)
    line.append(" [in ").append(kPlaces[static_cast<int>(innermost->where)]);
  if (innermost && innermost->object)
    line += " of " + innermost->object->text();
  if (innermost)
    line += "]";
  const std::lock_guard lock(report_mutex);
  if (reported().insert(line).second)
    print(line);
}

bool any_violation() {
  const std::lock_guard lock(report_mutex);
  return !reported().empty();
}

Call* current_call() noexcept { return innermost; }
Role current_role() noexcept { return role; }
void set_role(Role r) noexcept { role = r; }

ApiCall::ApiCall(const char* function, unsigned roles) {
  if (depth++ == 0)
    watch_perform(0);
  if ((roles & role) == 0)
    violation(std::string(function) + ": called from " +
              (role == kMain        ? "the main thread"
               : role == kScheduler ? "the scheduler's thread"
               : role == kAudio     ? "the audio thread"
                                    : "a thread of the external's own"));
  if (innermost && innermost->where == Where::kFree && innermost->object->in_chain &&
      std::string_view(function) != "z_dsp_free")
    violation(std::string(function) + ": z_dsp_free must come first in a free method");
}
ApiCall::~ApiCall() {
  if (--depth == 0)
    watch_perform(1);
}

void run_external(Call& call, const std::function<void()>& function) {
  call.outer = innermost;
  innermost = &call;
  const int before = std::exchange(depth, 0);
  watch_perform(1);
  try {
    function();
  } catch (...) {
    violation("an exception left the external's function");
  }
  watch_perform(0);
  depth = before + 1;
  if (call.held > 0)
    violation("a critical region or a buffer's lock is not left");
  innermost = call.outer;
  depth = before;
}

} // namespace tactus::stub

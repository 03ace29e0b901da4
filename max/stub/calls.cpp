// Who calls: threads, and the external's function that each is in.
#include "max/stub/kernel.hpp"

namespace tactus::stub {
namespace {
constinit thread_local Role role = Role::kForeign;
constinit thread_local Call* innermost = nullptr;
constinit thread_local int kernel_depth = 0; // > 0: in the stub, not in an external

const char* role_name(Role r) {
  switch (r) {
  case Role::kMain:
    return "the main thread";
  case Role::kScheduler:
    return "the scheduler's thread";
  case Role::kAudio:
    return "the audio thread";
  case Role::kForeign:
    break;
  }
  return "a thread of the external's own";
}

const char* where_name(Where where) {
  switch (where) {
  case Where::kLoad:
    return "ext_main";
  case Where::kConstruct:
    return "constructor";
  case Where::kFree:
    return "free method";
  case Where::kMessage:
    return "message";
  case Where::kSetter:
    return "setter";
  case Where::kGetter:
    return "getter";
  case Where::kAssist:
    return "assist";
  case Where::kDsp:
    return "dsp64";
  case Where::kPerform:
    return "perform";
  case Where::kCallback:
    break;
  }
  return "callback";
}
} // namespace

Call* current_call() noexcept { return innermost; }
Role current_role() noexcept { return role; }
void set_role(Role r) noexcept { role = r; }

std::string describe_call() {
  if (!innermost)
    return role == Role::kForeign ? role_name(role) : "";
  std::string text = where_name(innermost->where);
  if (!innermost->name.empty())
    text.append(" ").append(innermost->name);
  if (innermost->object)
    text += " of " + innermost->object->text();
  return text;
}

ApiCall::ApiCall(const char* function, unsigned roles) {
  ++kernel_depth;
  if ((roles & static_cast<unsigned>(role)) == 0)
    violation(std::string(function) + ": called from " + role_name(role));
  if (innermost && innermost->where == Where::kFree && innermost->object) {
    const Object& object = *innermost->object;
    if (object.type->dsp && !object.dsp_freed && std::string_view(function) != "z_dsp_free" &&
        std::string_view(function) != "gensym")
      violation(std::string("z_dsp_free must come first in a free method: ") + function);
  }
}
ApiCall::~ApiCall() { --kernel_depth; }

HostWork::HostWork() noexcept { ++kernel_depth; }
HostWork::~HostWork() { --kernel_depth; }

bool in_external() noexcept { return innermost && kernel_depth == 0; }

Entered::Entered(Call& call) noexcept : call_(call), kernel_depth_(kernel_depth) {
  call.outer = innermost;
  innermost = &call;
  kernel_depth = 0;
}
Entered::~Entered() {
  kernel_depth = kernel_depth_ + 1;
  if (call_.critical > 0)
    violation("critical_enter without critical_exit");
  if (call_.buffer_locks > 0)
    violation("buffer_locksamples without buffer_unlocksamples");
  innermost = call_.outer;
  kernel_depth = kernel_depth_;
}

void note_system_call(const char* function, bool releases) noexcept {
  if (!in_external())
    return;
  const HostWork work;
  if (innermost->where == Where::kPerform)
    violation(std::string(function) + " in perform: it may not allocate, lock or call the system");
  else if (releases && innermost->where == Where::kFree && innermost->object &&
           innermost->object->type->dsp && !innermost->object->dsp_freed)
    violation("z_dsp_free must come first in a free method: memory was freed before");
}

} // namespace tactus::stub

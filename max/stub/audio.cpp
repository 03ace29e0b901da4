// MaxAudio's functions, and the chain that performs.
#include "max/stub/audio.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace tactus::stub {
namespace {
constexpr std::uint64_t kUnwritten = 0x7ff4'dead'0000'0001ULL; // a NaN that nobody computes
constexpr std::size_t kBeyond = 4;                             // pointers after the last vector
std::recursive_mutex chain_mutex; // held while a vector is performed, and while the chain changes
std::vector<std::unique_ptr<Performer>> performers;
std::atomic<bool> running{false};
std::atomic<std::uint64_t> position{0};
t_object chain_header{nullptr, kMagic, nullptr, nullptr};

double* beyond_inputs() {
  static ForbiddenPages pages("an inlet's vector that there is not");
  return pages.data();
}
double* beyond_outputs() {
  static ForbiddenPages pages("an outlet's vector that there is not");
  return pages.data();
}
std::size_t signal_outlets(const Object& object) {
  return static_cast<std::size_t>(std::count_if(object.outlets.begin(), object.outlets.end(),
                                                [](const Outlet* o) { return o->signal(); }));
}

void allocate(Performer& p) {
  const auto count = static_cast<std::size_t>(audio_settings().vector);
  p.in.clear();
  p.out.clear();
  p.kept.assign(p.inputs.size(), std::vector<double>(count));
  for (std::size_t i = 0; i < p.inputs.size(); ++i) {
    p.in.push_back(std::make_unique<GuardedVector>(count, "inlet " + std::to_string(i)));
    if (!p.inputs[i].connected() && !audio_settings().zeros_unconnected)
      p.in.back()->forbid(true);
  }
  for (std::size_t i = 0; i < signal_outlets(*p.object); ++i)
    p.out.push_back(std::make_unique<GuardedVector>(count, "outlet " + std::to_string(i)));
  p.levels.resize(p.out.size());
}

void call_dsp64(Performer& p) {
  Object& object = *p.object;
  const Method* dsp = object.type->find("dsp64");
  p.added.clear();
  if (!dsp || !object.dsp_set_up)
    return;
  constexpr short kGuard = 0x5B5B;
  std::vector<short> count;
  for (const Input& input : p.inputs)
    count.push_back(input.connected() ? 1 : 0);
  count.resize(p.inputs.size() + signal_outlets(object), 1);
  const std::size_t used = count.size();
  count.resize(used + 8, kGuard);
  Call call{.where = Where::kDsp, .object = &object, .chain = &chain_header};
  const AudioSettings& s = audio_settings();
  run_external(call, [&] {
    as<void (*)(void*, t_object*, short*, double, long, long)>(dsp->function)(
        object.header(), &chain_header, count.data(), s.sample_rate, s.max_vector, 0);
  });
  if (std::any_of(count.begin() + static_cast<std::ptrdiff_t>(used), count.end(),
                  [](short c) { return c != kGuard; }))
    violation(object.text() + ": dsp64 wrote beyond its counts");
  p.no_inplace = (reinterpret_cast<const t_pxobject*>(object.header())->z_misc & Z_NO_INPLACE) != 0;
}

void fill_inputs(Performer& p) {
  for (std::size_t i = 0; i < p.inputs.size(); ++i) {
    const Input& input = p.inputs[i];
    if (!input.connected())
      continue;
    if (input.box) {
      const auto* from = input.box->performer;
      if (from && input.outlet < from->out.size())
        std::copy(from->out[input.outlet]->all().begin(), from->out[input.outlet]->all().end(),
                  p.in[i]->data());
    } else
      input.source(p.in[i]->all(), position.load(std::memory_order_relaxed));
    std::copy(p.in[i]->all().begin(), p.in[i]->all().end(), p.kept[i].begin());
  }
}

/// The output vectors: their own, or some of the inputs'.
std::vector<double*> outputs_of(const Performer& p) {
  std::vector<double*> out;
  const std::size_t inlets = p.in.size();
  for (std::size_t i = 0; i < p.out.size(); ++i) {
    const std::size_t shared = audio_settings().inplace == Inplace::kCrossed ? inlets - 1 - i : i;
    const bool alias = audio_settings().inplace != Inplace::kOff && !p.no_inplace && i < inlets &&
                       p.inputs[shared].connected();
    out.push_back(alias ? p.in[shared]->data() : p.out[i]->data());
    if (!alias)
      std::fill_n(p.out[i]->data(), p.out[i]->all().size(), std::bit_cast<double>(kUnwritten));
  }
  return out;
}

void check_vectors(Performer& p, const std::vector<double*>& out) {
  const auto n = static_cast<std::size_t>(audio_settings().vector);
  const std::string start = p.object->text() + ": ";
  for (std::size_t i = 0; i < p.in.size(); ++i) {
    const bool aliased = std::find(out.begin(), out.end(), p.in[i]->data()) != out.end();
    if (p.inputs[i].connected() && !aliased &&
        std::memcmp(p.in[i]->data(), p.kept[i].data(), n * sizeof(double)) != 0)
      violation(start + "perform wrote to the vector of inlet " + std::to_string(i));
    if (!p.in[i]->front_intact())
      violation(start + "perform wrote before the vector of inlet " + std::to_string(i));
  }
  const bool muted = reinterpret_cast<const t_pxobject*>(p.object->header())->z_disabled != 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!p.out[i]->front_intact())
      violation(start + "perform wrote before the vector of outlet " + std::to_string(i));
    if (!p.entries.empty() && std::any_of(out[i], out[i] + n, [](double v) {
          return std::bit_cast<std::uint64_t>(v) == kUnwritten;
        }))
      violation(start + "perform did not write all of outlet " + std::to_string(i));
    if (p.entries.empty())
      std::fill_n(out[i], n, 0.0); // Max's vectors are cleared
    if (muted && std::any_of(out[i], out[i] + n, [](double v) { return v != 0; }))
      violation(start + "z_disabled, and outlet " + std::to_string(i) + " is not silent");
  }
}

void keep_outputs(Performer& p, const std::vector<double*>& out) {
  const auto n = static_cast<std::size_t>(audio_settings().vector);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (out[i] != p.out[i]->data())
      std::copy_n(out[i], n, p.out[i]->data());
    for (double v : p.out[i]->all()) {
      Performer::Level& level = p.levels[i];
      ++level.samples;
      if (!std::isfinite(v)) {
        ++level.not_finite;
        continue;
      }
      level.peak = std::max(level.peak, std::abs(v));
      level.square_sum += v * v;
    }
  }
  for (std::size_t k = 0; p.recorded && k < n; ++k)
    for (const auto& vector : p.out)
      p.recorded->push_back(vector->data()[k]);
}

void perform(Performer& p) {
  fill_inputs(p);
  std::vector<double*> in, out = outputs_of(p);
  for (const auto& vector : p.in)
    in.push_back(vector->data());
  const std::vector<double*> real_out = out;
  in.resize(in.size() + kBeyond, beyond_inputs());
  out.resize(out.size() + kBeyond, beyond_outputs());
  std::vector<double*> given_in = in, given_out = out;
  for (const Performer::Entry& entry : p.entries) {
    Call call{.where = Where::kPerform, .object = p.object};
    run_external(call, [&] {
      entry.function(p.object->header(), &chain_header, given_in.data(),
                     static_cast<long>(p.in.size()), given_out.data(),
                     static_cast<long>(p.out.size()), audio_settings().vector, entry.flags,
                     entry.user);
    });
  }
  if (given_in != in || given_out != out)
    violation(p.object->text() + ": perform changed the table of vectors");
  check_vectors(p, real_out);
  keep_outputs(p, real_out);
}

void tell_state(Object& object, long on) {
  const Method* state = object.type->find("dspstate");
  if (!state)
    return;
  Call call{.where = Where::kMessage, .object = &object, .name = "dspstate"};
  run_external(call, [&] { as<void (*)(void*, long)>(state->function)(object.header(), on); });
}
} // namespace

AudioSettings& audio_settings() {
  static AudioSettings settings;
  return settings;
}
bool dsp_runs() { return running; }
std::uint64_t sample_position() { return position.load(std::memory_order_relaxed); }

Performer& performer_of(Object& object) {
  if (!object.performer) {
    const std::lock_guard lock(chain_mutex);
    performers.push_back(std::make_unique<Performer>());
    object.performer = performers.back().get();
    object.performer->object = &object;
    object.performer->inputs.resize(static_cast<std::size_t>(object.signal_inlets));
  }
  return *object.performer;
}

void connect_input(Object& object, std::size_t inlet, Input input) {
  Performer& p = performer_of(object);
  const std::lock_guard lock(chain_mutex);
  p.inputs.at(inlet) = std::move(input);
  if (running)
    p.entries.clear(); // Max compiles the chain anew; until then silence
}

void start_dsp() {
  const HostWork work;
  const bool before = running;
  for (Object* object : living_objects())
    if (object->type->dsp)
      performer_of(*object);
  // Only the main thread changes the list. The old chain performs while dsp64 runs, as in Max.
  for (const auto& p : performers) {
    if (!before)
      tell_state(*p->object, 1);
    call_dsp64(*p);
  }
  const std::lock_guard lock(chain_mutex);
  for (const auto& p : performers) {
    allocate(*p);
    p->entries = std::move(p->added);
    p->object->performing = !p->entries.empty();
  }
  running = true;
}

void stop_dsp() {
  const HostWork work;
  {
    const std::lock_guard lock(chain_mutex);
    if (!running.exchange(false))
      return;
    for (const auto& p : performers) {
      p->entries.clear();
      p->object->performing = false;
    }
  }
  for (const auto& p : performers)
    tell_state(*p->object, 0);
}

void perform_vector() {
  const HostWork work;
  const std::lock_guard lock(chain_mutex);
  if (!running)
    return;
  const Role before = current_role();
  set_role(Role::kAudio);
  for (const auto& p : performers)
    if (!p->in.empty() || !p->out.empty() || !p->entries.empty())
      perform(*p);
  set_role(before);
  position.fetch_add(static_cast<std::uint64_t>(audio_settings().vector),
                     std::memory_order_relaxed);
}

void remove_from_chain(Object& object) {
  const HostWork work;
  const std::lock_guard lock(chain_mutex);
  for (const auto& p : performers)
    for (Input& input : p->inputs)
      if (input.box == &object)
        input.box = nullptr;
  std::erase_if(performers, [&](const auto& p) { return p->object == &object; });
  object.performer = nullptr;
  object.performing = false;
}

} // namespace tactus::stub

using namespace tactus::stub;

void class_dspinit(t_class* c) {
  const ApiCall api("class_dspinit", static_cast<unsigned>(Role::kMain));
  t_class* type = require<t_class>(c, "class_dspinit");
  if (!type)
    return;
  if (type->registered)
    violation("class_dspinit: after class_register of " + type->name);
  if (type->dsp)
    violation("class_dspinit: twice for " + type->name);
  type->dsp = true;
}

void z_dsp_setup(t_pxobject* x, long inlets) {
  const ApiCall api("z_dsp_setup", static_cast<unsigned>(Role::kMain));
  Object* object = require_object(x, "z_dsp_setup");
  if (!object)
    return;
  const std::string start = "z_dsp_setup: " + object->text() + ": ";
  if (object->constructed)
    violation(start + "outside the constructor");
  if (!object->type->dsp) {
    violation(start + "a class without class_dspinit");
    return;
  }
  if (object->dsp_set_up) {
    violation(start + "twice");
    return;
  }
  if (inlets < 0)
    violation(start + std::to_string(inlets) + " inlets");
  if (!object->proxies.empty() && object->proxies.back()->id != std::max(inlets, 1L))
    violation(start + "the proxies to the right begin with inlet " +
              std::to_string(object->proxies.back()->id) + ", but there are " +
              std::to_string(inlets) + " signal inlets");
  object->dsp_set_up = true;
  object->signal_inlets = std::max(inlets, 0L);
  x->z_count = static_cast<short>(inlets);
  for (long id = inlets - 1; id >= 1; --id) {
    auto* proxy = new Proxy;
    add_record(proxy, proxy);
    proxy->id = id;
    proxy->inlet = &x->z_in;
    proxy->of_dsp = true;
    object->proxies.push_back(proxy);
    x->z_proxy = proxy;
  }
}

void z_dsp_free(t_pxobject* x) {
  const ApiCall api("z_dsp_free", static_cast<unsigned>(Role::kMain));
  Object* object = require_object(x, "z_dsp_free");
  if (!object)
    return;
  if (!current_call() || current_call()->where != Where::kFree)
    violation("z_dsp_free: outside a free method");
  if (!object->type->dsp)
    violation("z_dsp_free: a class without class_dspinit");
  if (object->dsp_freed)
    violation("z_dsp_free: twice");
  remove_from_chain(*object);
  object->dsp_freed = true;
  for (Proxy* proxy : object->proxies)
    if (proxy->of_dsp)
      proxy->alive = false;
}

void dsp_add64(t_object* chain, t_object* x, t_perfroutine64 function, long flags, void* user) {
  const ApiCall api("dsp_add64", static_cast<unsigned>(Role::kMain));
  Object* object = require_object(x, "dsp_add64");
  const Call* call = current_call();
  if (!object)
    return;
  if (!call || call->where != Where::kDsp)
    violation("dsp_add64: outside dsp64");
  else if (call->object != object)
    violation("dsp_add64: of another object");
  else if (chain != call->chain)
    violation("dsp_add64: to another chain than dsp64 was given");
  else if (!function)
    violation("dsp_add64: no function");
  else
    performer_of(*object).added.push_back({function, flags, user});
}

int sys_getdspobjdspstate(t_object* x) {
  const ApiCall api("sys_getdspobjdspstate", kAnyThread);
  Object* object = require_object(x, "sys_getdspobjdspstate");
  return object && object->performing ? 1 : 0;
}

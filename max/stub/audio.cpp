// MaxAudio's functions of the signal chain, and the chain itself.
#include "max/stub/stub.hpp"

#include "files/utf8_path.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>

namespace tactus::stub {
namespace {
constexpr double kUnwritten =
    std::bit_cast<double>(0x7ff8'dead'0000'0001ULL); // a NaN that no computation yields
constexpr std::size_t kGuard = 4;                    // guard samples on both sides of a vector
std::atomic<std::uint64_t> position{0};
t_object chain{};

bool is_unwritten(double v) {
  return std::bit_cast<std::uint64_t>(v) == std::bit_cast<std::uint64_t>(kUnwritten);
}
std::size_t signal_outlets(const Object& object) {
  return static_cast<std::size_t>(std::count_if(object.outlets.begin(), object.outlets.end(),
                                                [](const Outlet* o) { return o->signal; }));
}
bool guards_intact(const std::vector<double>& vector) {
  return std::all_of(vector.begin(), vector.begin() + kGuard, is_unwritten) &&
         std::all_of(vector.end() - kGuard, vector.end(), is_unwritten);
}

void compile(Object& object) {
  const auto frames = static_cast<std::size_t>(audio().vector);
  const std::vector<double> vector(frames + 2 * kGuard, kUnwritten);
  object.in.assign(object.sources.size(), vector);
  object.out.assign(signal_outlets(object), vector);
  std::vector<short> connected;
  for (const Source& source : object.sources)
    connected.push_back(source ? 1 : 0);
  connected.resize(connected.size() + object.out.size(), 1);
  Call call{.where = Where::kDsp, .object = &object};
  run_external(call, [&] {
    as<void (*)(void*, t_object*, short*, double, long, long)>(
        object.type->find("dsp64")->function)(object.header(), &chain, connected.data(),
                                              audio().sample_rate, audio().vector, 0);
  });
}

/// Vectors of unconnected inlets are null here, so that no object may read them; in Max they are
/// zeros.
void perform(Object& object, std::uint64_t sample) {
  const auto frames = static_cast<std::size_t>(audio().vector);
  std::vector<double*> in, out;
  for (std::size_t i = 0; i < object.in.size(); ++i) {
    double* samples = object.in[i].data() + kGuard;
    in.push_back(object.sources[i] ? samples : nullptr);
    for (std::size_t k = 0; object.sources[i] && k < frames; ++k)
      samples[k] = object.sources[i](sample + k);
  }
  for (std::size_t i = 0; i < object.out.size(); ++i) {
    const std::size_t shared = audio().inplace == Inplace::kCrossed ? in.size() - 1 - i : i;
    const bool aliased = audio().inplace != Inplace::kOff && i < in.size() && in[shared];
    std::fill_n(object.out[i].data() + kGuard, frames, kUnwritten);
    out.push_back(aliased ? in[shared] : object.out[i].data() + kGuard);
  }
  const std::vector<std::vector<double>> given = object.in;
  Call call{.where = Where::kPerform, .object = &object};
  run_external(call, [&] {
    object.perform(&object.header()->z_ob, &chain, in.data(), static_cast<long>(in.size()),
                   out.data(), static_cast<long>(out.size()), audio().vector, 0, object.user);
  });
  for (std::size_t i = 0; i < in.size(); ++i)
    if (std::find(out.begin(), out.end(), object.in[i].data() + kGuard) == out.end() &&
        std::memcmp(object.in[i].data(), given[i].data(), given[i].size() * sizeof(double)) != 0)
      violation(object.text() + ": perform wrote to the vector of an inlet");
  const bool muted = object.header()->z_disabled != 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (std::any_of(out[i], out[i] + frames, is_unwritten))
      violation(object.text() + ": perform did not write all of an outlet's vector");
    if (muted && std::any_of(out[i], out[i] + frames, [](double v) { return v != 0; }))
      violation(object.text() + ": z_disabled, and an outlet is not silent");
    std::copy_n(out[i], frames, object.out[i].data() + kGuard);
  }
  for (const auto* vectors : {&object.in, &object.out})
    if (!std::all_of(vectors->begin(), vectors->end(), guards_intact))
      violation(object.text() + ": perform wrote beyond a vector");
  for (std::size_t k = 0; !object.recording.empty() && k < frames; ++k)
    for (const auto& vector : object.out)
      object.recorded.push_back(vector[kGuard + k]);
}
} // namespace

Audio& audio() {
  static Audio settings;
  return settings;
}
double audio_ms() {
  return 1e3 * static_cast<double>(position.load(std::memory_order_relaxed)) / audio().sample_rate;
}

void start_dsp() {
  for (Object* object : living_objects())
    if (object->in_chain)
      compile(*object);
  audio().runs = true;
}
void stop_dsp() { audio().runs = false; }

void perform_vector() {
  if (!audio().runs)
    return;
  const Role before = current_role();
  set_role(kAudio);
  const std::uint64_t sample = position.load(std::memory_order_relaxed);
  for (Object* object : living_objects())
    if (object->perform)
      perform(*object, sample);
  set_role(before);
  position.store(sample + static_cast<std::uint64_t>(audio().vector), std::memory_order_relaxed);
}

void write_recording(Object& object) {
  if (object.recording.empty())
    return;
  std::ofstream stream(utf8_path(object.recording), std::ios::binary);
  stream.write(reinterpret_cast<const char*>(object.recorded.data()),
               static_cast<std::streamsize>(object.recorded.size() * sizeof(double)));
}

} // namespace tactus::stub

using namespace tactus::stub;

void class_dspinit(t_class* c) {
  const ApiCall api("class_dspinit", kMain);
  c->dsp = true;
}
void z_dsp_setup(t_pxobject* x, long inlets) {
  const ApiCall api("z_dsp_setup", kMain);
  Object* object = require_object(x, "z_dsp_setup");
  if (!object->proxies.empty() && object->proxies.back()->id != std::max(inlets, 1L))
    violation("z_dsp_setup: other proxies than those right of the signal inlets");
  object->in_chain = true;
  object->signal_inlets = inlets;
  object->sources.resize(static_cast<std::size_t>(inlets));
  for (long id = inlets - 1; id >= 1; --id) {
    auto* proxy = new Proxy; // the external must not free it
    proxy->id = id;
    proxy->inlet = &x->z_in;
    object->proxies.push_back(proxy);
  }
}
void z_dsp_free(t_pxobject* x) {
  const ApiCall api("z_dsp_free", kMain);
  Object* object = require_object(x, "z_dsp_free");
  if (!object->in_chain)
    violation("z_dsp_free: twice, or of an object without z_dsp_setup");
  object->in_chain = false;
  object->perform = nullptr;
}
void dsp_add64(t_object*, t_object* x, t_perfroutine64 function, long, void* user) {
  const ApiCall api("dsp_add64", kMain);
  Object* object = require_object(x, "dsp_add64");
  if (current_call()->where != Where::kDsp)
    violation("dsp_add64: outside dsp64");
  object->perform = function;
  object->user = user;
}
int sys_getdspobjdspstate(t_object* x) {
  const ApiCall api("sys_getdspobjdspstate", kAnyThread);
  return audio().runs && require_object(x, "sys_getdspobjdspstate")->perform ? 1 : 0;
}

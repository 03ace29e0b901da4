// One small external, right as it stands, or wrong in the one respect of which the host must say
// what MISTAKE says (test_host.py). Its signal is inlet 0 times gain.
#include "max/abi/max_abi.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <thread>

namespace {
const char* const chosen = std::getenv("MISTAKE");
bool provokes(std::string_view violation) { return chosen && violation == chosen; }
template <class Mistake> void when(const char* violation, Mistake mistake) {
  if (provokes(violation))
    mistake();
}

struct Small {
  t_pxobject header;
  void* signal_outlet;
  void* message_outlet;
  void* proxy;
  void* clock;
  void* qelem;
  long inlet_of_proxy;
  std::atomic<double> gain;
  double planted; // without a lock
};
t_class* small_class = nullptr;

template <class Function> method erased(Function function) {
  return reinterpret_cast<method>(reinterpret_cast<void (*)()>(function));
}

void perform(Small* x, t_object*, double** in, long, double** out, long, long n, long, void*) {
  when("outlet_float: called from the audio thread", [&] { outlet_float(x->message_outlet, 1); });
  when("gensym: called from the audio thread", [&] { gensym("performing"); });
  when("malloc on the audio path", [] {
    void* volatile memory = std::malloc(100);
    std::free(memory);
  });
  when("an exception left the external's function [in perform", [] { throw 1; });
  double gain = x->gain.load(std::memory_order_relaxed);
  when("race", [&] { gain = x->planted; });
  const bool muted =
      x->header.z_disabled != 0 && !provokes("z_disabled, and an outlet is not silent");
  const long length = n - (provokes("perform did not write all of an outlet's vector") ? 1 : 0);
  for (long i = 0; i < length; ++i)
    out[0][i] = muted || !in[0] ? 0 : in[0][i] * gain;
  when("perform wrote beyond a vector", [&] { out[0][n] = 0; });
  when("perform wrote to the vector of an inlet", [&] { in[0][0] = 2; });
  qelem_set(x->qelem);
}
void dsp64(Small* x, t_object* chain, short*, double, long, long) {
  dsp_add64(chain, &x->header.z_ob,
            reinterpret_cast<t_perfroutine64>(reinterpret_cast<void (*)()>(perform)), 0, nullptr);
}

void float_message(Small* x, double value) {
  when("proxy_getinlet: after an outlet was used", [&] { outlet_float(x->message_outlet, value); });
  const bool left = proxy_getinlet(&x->header.z_ob) == 0;
  when("race", [&] { x->planted = value; });
  when("outlet_float: within a critical region", [] { critical_enter(nullptr); });
  if (left)
    outlet_float(
        provokes("outlet_float: to a signal outlet") ? x->signal_outlet : x->message_outlet, value);
  when("outlet_float: within a critical region", [] { critical_exit(nullptr); });
  when("a critical region or a buffer's lock is not left", [] { critical_enter(nullptr); });
}
void bang(Small* x) {
  clock_fdelay(x->clock, 5);
  when("clock_fdelay: of another kind of thing", [&] { clock_fdelay(x->message_outlet, 1); });
  when("outlet_bang: null", [] { outlet_bang(nullptr); });
  when("clock_fdelay: a delay of -1", [&] { clock_fdelay(x->clock, -1); });
  when("a box is freed by its patcher only", [&] { object_free(x); });
  when("proxy_new: outside the constructor", [&] { proxy_new(x, 1, &x->inlet_of_proxy); });
  if (provokes("outlet_bang: called from a thread of the external's own"))
    std::thread([x] { outlet_bang(x->message_outlet); }).join();
}
void list(Small* x, t_symbol*, long count, t_atom* atoms) {
  outlet_list(x->message_outlet, nullptr, static_cast<short>(count), atoms);
}
void on_clock(Small* x) {
  when("proxy_getinlet: outside a message", [&] { proxy_getinlet(&x->header.z_ob); });
  outlet_bang(x->message_outlet);
}
void on_qelem(Small*) { path_getdefault(); } // of the main thread alone, as this is

void assist(Small*, void*, long, long, char* text) {
  std::snprintf(text, 256, "a port");
  if (provokes("assist writes more than 256 characters"))
    std::snprintf(text, 300, "%0256d", 0); // 256 characters and the zero
}
t_max_err get_gain(Small* x, void*, long* count, t_atom** atoms) {
  char allocated = 0;
  const bool too_many =
      provokes("the getter of gain returns more atoms than it was given room for");
  atom_alloc(count, atoms, &allocated);
  atom_setfloat(*atoms, x->gain);
  if (too_many && !allocated)
    atom_setfloat(*atoms + 1, 0);
  return provokes("the getter of gain fails") ? -1 : 0;
}
t_max_err set_gain(Small* x, void*, long, t_atom* atoms) {
  x->gain = atoms[0].a_w.w_float;
  object_attr_touch(&x->header.z_ob,
                    gensym(provokes("there is no attribute gian") ? "gian" : "gain"));
  return 0;
}

void free_small(Small* x) {
  when("clock_unset: z_dsp_free must come first", [&] { clock_unset(x->clock); });
  if (!provokes("z_dsp_free was not called by the free method"))
    z_dsp_free(&x->header);
  when("nothing can be sent from here", [&] { outlet_bang(x->message_outlet); });
  if (!provokes("a clock that is armed"))
    clock_unset(x->clock);
  if (!provokes("did not free a proxy, clock, qelem or buffer_ref"))
    object_free(x->clock);
  when("object_free: null, or freed twice", [&] { object_free(x->clock); });
  when("clock_fdelay: use of a thing after it was freed", [&] { clock_fdelay(x->clock, 1); });
  object_free(x->proxy);
  qelem_free(x->qelem);
}

void* new_small(t_symbol*, long count, t_atom* atoms) {
  auto* x = static_cast<Small*>(object_alloc(small_class));
  x->gain = 1;
  x->planted = 1;
  x->inlet_of_proxy = 0;
  when("make inlets from right to left", [&] { z_dsp_setup(&x->header, 1); });
  x->proxy = proxy_new(x, 1, &x->inlet_of_proxy);
  if (!provokes("make inlets from right to left") &&
      !provokes("the constructor did not call z_dsp_setup"))
    z_dsp_setup(&x->header, 1);
  void* dumpout = outlet_new(x, nullptr);
  x->message_outlet = outlet_new(x, nullptr);
  x->signal_outlet = outlet_new(x, "signal");
  object_obex_store(x, gensym("dumpout"),
                    static_cast<t_object*>(
                        provokes("dumpout is the leftmost outlet") ? x->signal_outlet : dumpout));
  x->clock = clock_new(x, erased(on_clock));
  x->qelem = qelem_new(x, erased(on_qelem));
  attr_args_process(x, static_cast<short>(count), atoms);
  return provokes("did not free what it made and does not return") ? nullptr : x;
}
} // namespace

extern "C" MAX_EXPORT void ext_main(void*) {
  t_class* c = class_new("small~", erased(new_small), erased(free_small),
                         static_cast<long>(sizeof(Small)), nullptr, A_GIMME, 0);
  if (!provokes("class_dspinit and a method dsp64 go together"))
    class_addmethod(c, erased(dsp64), "dsp64", A_CANT, 0);
  class_addmethod(c, erased(assist), "assist", A_CANT, 0);
  class_addmethod(c, erased(bang), "bang", 0);
  class_addmethod(c, erased(float_message), "float",
                  provokes("float has other types than Max's") ? A_LONG : A_FLOAT, 0);
  class_addmethod(c, erased(list), "list", A_GIMME, 0);
  if (provokes("loadbnag has other types than Max's, or Max calls no such method"))
    class_addmethod(c, erased(bang), "loadbnag", A_CANT, 0);
  if (provokes("the types of endless do not end with 0"))
    class_addmethod(c, erased(bang), "endless", A_LONG, A_LONG, A_LONG, A_LONG, A_LONG, A_LONG,
                    A_LONG, A_LONG, 0);
  class_addattr(c, attribute_new("gain", gensym("float64"), 0, erased(get_gain), erased(set_gain)));
  if (provokes("gain is there twice"))
    class_addmethod(c, erased(bang), "gain", 0);
  class_dspinit(c);
  class_register(gensym("box"), c);
  small_class = c;
}

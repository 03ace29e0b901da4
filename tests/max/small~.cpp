// One small external, right as it stands, or wrong in the one respect of which the host must say
// what MISTAKE says (test_host.py).
#include "max/abi/max_abi.h"

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string_view>
#include <thread>

namespace {
const char* const chosen = std::getenv("MISTAKE");
bool provokes(std::string_view violation) { return chosen && violation == chosen; }
template <class Mistake> void when(const char* violation, Mistake mistake) {
  if (provokes(violation))
    mistake();
}
constexpr const char* kName = "small~";

struct Small {
  t_pxobject header;
  void* signal_outlet;
  void* message_outlet;
  void* dumpout;
  void* proxy;
  void* clock;
  void* qelem;
  t_buffer_ref* buffer;
  double* scratch;
  long inlet_of_proxy;
  std::atomic<double> gain;
  std::atomic<double> scalar;
  std::atomic<int> vectors;
  std::atomic<bool> connected[2];
  double planted; // without a lock
};
static_assert(offsetof(Small, header) == 0);
t_class* small_class = nullptr;
void* stray_clock = nullptr;

template <class Function> method erased(Function function) {
  return reinterpret_cast<method>(reinterpret_cast<void (*)()>(function));
}

// --- signals ---

void hold_lock() {
  static std::mutex mutex;
  mutex.lock();
  mutex.unlock();
}

/// What no external may do in the audio thread.
void misbehave(Small* x) {
  when("outlet_float: called from the audio thread", [&] { outlet_float(x->message_outlet, 1); });
  if (provokes("object_post: called from the audio thread"))
    object_post(&x->header.z_ob, "performing");
  when("gensym: called from the audio thread", [&] { gensym("performing"); });
  if (provokes("critical_enter: called from the audio thread")) {
    critical_enter(nullptr);
    critical_exit(nullptr);
  }
  if (provokes("malloc in perform")) {
    void* volatile memory = std::malloc(100);
    std::free(memory);
  }
  when("pthread_mutex_lock in perform", [&] { hold_lock(); });
  when("proxy_getinlet: called from the audio thread", [&] { proxy_getinlet(&x->header.z_ob); });
  when("an exception left the external's function [in perform", [&] { throw 1; });
}

void perform(Small* x, t_object*, double** in, long inlets, double** out, long outlets, long n,
             long, void*) {
  misbehave(x);
  x->vectors.fetch_add(1, std::memory_order_relaxed);
  const bool muted =
      x->header.z_disabled != 0 && !provokes("z_disabled, and outlet 0 is not silent");
  const bool connected = x->connected[1].load(std::memory_order_relaxed) ||
                         provokes("inlet 1, which is not connected");
  const bool silent = muted || !x->connected[0].load(std::memory_order_relaxed);
  const double scalar = x->scalar.load(std::memory_order_relaxed);
  double gain = x->gain.load(std::memory_order_relaxed);
  when("race", [&] { gain = x->planted; });
  const long length = provokes("memory beyond the end of outlet 0")       ? n + 1
                      : provokes("perform did not write all of outlet 0") ? n - 1
                                                                          : n;
  for (long i = 0; i < length; ++i)
    out[0][i] = silent ? 0 : in[0][i] * (connected ? in[1][i] : scalar) * gain;
  when("perform wrote before the vector of outlet 0", [&] { out[0][-1] = 0; });
  when("perform wrote before the vector of inlet 0", [&] { in[0][-1] = 0; });
  when("perform changed the table of vectors", [&] { in[0] = nullptr; });
  when("perform wrote to the vector of inlet 0", [&] { in[0][0] = 2; });
  when("memory beyond the end of inlet 0", [&] { x->scalar = in[0][n]; });
  when("an inlet's vector that there is not", [&] { x->scalar = in[inlets][0]; });
  when("an outlet's vector that there is not", [&] { out[outlets][0] = 0; });
  qelem_set(x->qelem);
}

void dsp64(Small* x, t_object* chain, short* count, double, long, long) {
  for (std::size_t i = 0; i < 2; ++i)
    x->connected[i] = count[i] != 0;
  when("dsp_add64: to another chain than dsp64 was given", [&] { chain = &x->header.z_ob; });
  when("dsp64 wrote beyond its counts", [&] { count[3] = 1; });
  dsp_add64(chain, &x->header.z_ob,
            reinterpret_cast<t_perfroutine64>(reinterpret_cast<void (*)()>(perform)), 0, nullptr);
}

// --- messages ---

void float_message(Small* x, double value) {
  when("proxy_getinlet: after an outlet was used", [&] { outlet_float(x->message_outlet, value); });
  const long inlet = proxy_getinlet(&x->header.z_ob);
  if (inlet == 1)
    x->scalar = value;
  when("race", [&] { x->planted = value; });
  qelem_set(x->qelem);
  when("outlet_float: within a critical region", [&] { critical_enter(nullptr); });
  outlet_float(provokes("outlet_float: to a signal outlet") ? x->signal_outlet : x->message_outlet,
               value);
  when("outlet_float: within a critical region", [&] { critical_exit(nullptr); });
  when("critical_enter without critical_exit", [&] { critical_enter(nullptr); });
  when("critical_exit without critical_enter", [&] { critical_exit(nullptr); });
}
void int_message(Small* x, t_atom_long value) { float_message(x, static_cast<double>(value)); }

void loadbang(Small* x) { outlet_bang(x->message_outlet); }

/// Calls that no object may make in a message.
void misuse(Small* x) {
  t_object own{};
  when("z_dsp_free: outside a free method", [&] { z_dsp_free(&x->header); });
  if (provokes("class_new: late~: outside ext_main"))
    class_new("late~", erased(loadbang), nullptr, 100, nullptr, A_GIMME, 0);
  when("object_alloc: outside a constructor", [&] { object_alloc(small_class); });
  when("attr_args_process: outside the constructor", [&] { attr_args_process(x, 0, nullptr); });
  if (provokes("object_free: a proxy of z_dsp_setup, which z_dsp_free frees"))
    object_free(x->header.z_proxy);
  when("object_free does not free this kind: outlet", [&] { object_free(x->message_outlet); });
  when("object_post: not an object of Max", [&] { object_post(&own, "hello"); });
  when("jpatcher_get_filepath: not a patcher", [&] { jpatcher_get_filepath(&x->header.z_ob); });
  if (provokes("jpatcher_get_parentpatcher: not a patcher"))
    jpatcher_get_parentpatcher(&x->header.z_ob);
  when("clock_fdelay: an outlet instead of clock", [&] { clock_fdelay(x->message_outlet, 1); });
  when("outlet_bang: not an outlet that Max gave", [&] { outlet_bang(x->scratch); });
  when("outlet_bang: null instead of outlet", [&] { outlet_bang(nullptr); });
  when("clock_fdelay: a delay of -1", [&] { clock_fdelay(x->clock, -1); });
  if (provokes("critical_enter: a region that is not from critical_new"))
    critical_enter(reinterpret_cast<t_critical>(x));
  if (provokes("outlet_list: a wrong count of atoms: -1"))
    outlet_list(x->message_outlet, nullptr, -1, nullptr);
  if (provokes("outlet_list: a selector other than list"))
    outlet_list(x->message_outlet, gensym("words"), 0, nullptr);
  if (provokes("buffer_unlocksamples without buffer_locksamples"))
    if (t_buffer_obj* samples = buffer_ref_getobject(x->buffer))
      buffer_unlocksamples(samples);
  when("gensym: null instead of a text", [&] { gensym(nullptr); });
  when("clock_getftime: null", [&] { clock_getftime(nullptr); });
  when("atom_alloc: null instead of an address", [&] { atom_alloc(nullptr, nullptr, nullptr); });
  when("qelem_new: no function", [&] { qelem_new(x, nullptr); });
}

void bang(Small* x) {
  misuse(x);
  clock_fdelay(x->clock, 5);
  when("object_free: double free of clock", [&] { object_free(stray_clock); });
  when("object_free: not an object that Max gave", [&] { object_free(x->scratch); });
  when("object_free: a box is freed by its patcher only", [&] { object_free(x); });
  when("outlet_new: outside the constructor", [&] { outlet_new(x, nullptr); });
  if (provokes("dsp_add64: outside dsp64"))
    dsp_add64(&x->header.z_ob, &x->header.z_ob,
              reinterpret_cast<t_perfroutine64>(reinterpret_cast<void (*)()>(perform)), 0, nullptr);
  if (provokes("outlet_bang: called from a thread of the external's own"))
    std::thread([x] { outlet_bang(x->message_outlet); }).join();
  if (provokes("buffer_locksamples without buffer_unlocksamples"))
    if (t_buffer_obj* samples = buffer_ref_getobject(x->buffer))
      buffer_locksamples(samples);
  if (provokes("memory beyond the end of buffer~ samples"))
    if (t_buffer_obj* samples = buffer_ref_getobject(x->buffer)) {
      const float* first = buffer_locksamples(samples);
      x->scalar = static_cast<double>(
          first[buffer_getframecount(samples) * buffer_getchannelcount(samples)]);
      buffer_unlocksamples(samples);
    }
}

void list(Small* x, t_symbol*, long count, t_atom* atoms) {
  if (provokes("outlet_list: an atom of wrong type 77") && count > 0)
    atoms[0].a_type = 77;
  outlet_list(x->message_outlet, nullptr, static_cast<short>(count), atoms);
}
/// "find NAME": where Max finds the file.
void find_file(Small* x, const char* wanted) {
  char name[MAX_FILENAME_CHARS], found[MAX_PATH_CHARS], path[MAX_PATH_CHARS];
  std::snprintf(name, sizeof name, "%s", wanted);
  short folder = 0;
  t_fourcc type = 0;
  if (locatefile_extended(name, &folder, &type, nullptr, 0)) {
    object_error(&x->header.z_ob, "%s: no such file", wanted);
    return;
  }
  path_topathname(provokes("path_topathname: path 99 is none that Max gave") ? 99 : folder, name,
                  found);
  path_nameconform(found, path,
                   provokes("path_nameconform: no style or type of paths: 9") ? 9
                                                                              : PATH_STYLE_SLASH,
                   PATH_TYPE_ABSOLUTE);
  t_atom atom;
  atom_setsym(&atom, gensym(path));
  outlet_anything(x->message_outlet, gensym("found"), 1, &atom);
}
/// "sum": of the buffer's samples.
void sum_buffer(Small* x) {
  double sum = 0;
  if (t_buffer_obj* samples = buffer_ref_getobject(x->buffer)) {
    const float* all = buffer_locksamples(samples);
    const t_atom_long count = buffer_getframecount(samples) * buffer_getchannelcount(samples);
    for (t_atom_long i = 0; i < count; ++i)
      sum += static_cast<double>(all[i]);
    buffer_unlocksamples(samples);
  }
  outlet_float(x->message_outlet, sum);
}
/// "patcher" tells the file of its patcher and of the outermost.
bool other_message(Small* x, std::string_view name, long count, t_atom* atoms) {
  if (name == "find" && count == 1)
    find_file(x, atoms[0].a_w.w_sym->s_name);
  else if (name == "sum")
    sum_buffer(x);
  else if (name == "patcher") {
    t_object* patcher = nullptr;
    object_obex_lookup(x, gensym("#P"), &patcher);
    outlet_anything(x->message_outlet, jpatcher_get_filepath(patcher), 0, nullptr);
    while (t_object* parent = jpatcher_get_parentpatcher(patcher))
      patcher = parent;
    outlet_anything(x->message_outlet, jpatcher_get_filepath(patcher), 0, nullptr);
  } else
    return false;
  return true;
}
void anything(Small* x, t_symbol* s, long count, t_atom* atoms) {
  if (other_message(x, s->s_name, count, atoms))
    return;
  t_symbol own{s->s_name, nullptr};
  when("an exception left the external's function [in message", [&] { throw 1; });
  outlet_anything(x->message_outlet,
                  provokes("outlet_anything: a symbol that is not from gensym") ? &own : s,
                  static_cast<short>(count), atoms);
}
void on_clock(Small* x) {
  when("proxy_getinlet: outside a message", [&] { proxy_getinlet(&x->header.z_ob); });
  outlet_bang(x->message_outlet);
}
void on_qelem(Small* x) {
  x->vectors = 0;
  path_getdefault(); // of the main thread alone, as this is
}

void assist(Small*, void*, long direction, long index, char* text) {
  const char* what = direction == ASSIST_INLET
                         ? (index < 2 ? "(signal/float) factor" : "(message) words")
                     : index == 0 ? "(signal) product"
                                  : "(message) what came";
  std::snprintf(text, 256, "%s", what);
  if (provokes("assist writes more than 256 characters"))
    std::snprintf(text, 300, "%0256d", 0); // 256 characters and the zero
}

t_atom_long accepts_drag(Small* x, t_object* drag, t_object*) {
  if (provokes("acceptsdrag_locked: accepts, but names no message"))
    return 1;
  t_object other{};
  jdrag_object_add(
      provokes("jdrag_object_add: not the drag that the box is asked about") ? &other : drag,
      provokes("jdrag_object_add: a clock instead of object") ? static_cast<t_object*>(x->clock)
                                                              : &x->header.z_ob,
      gensym(provokes("jdrag_object_add: small~ a has no message assist") ? "assist" : "find"));
  return provokes("acceptsdrag_locked: refuses, but named a message") ? 0 : 1;
}

t_max_err get_gain(Small* x, void*, long* count, t_atom** atoms) {
  static t_atom own;
  char allocated = 0;
  if (provokes("the getter of gain returns atoms that are not from atom_alloc") ||
      (provokes("the getter of gain does not use the atoms that it was given") && *atoms)) {
    *count = 1;
    *atoms = &own;
  } else
    atom_alloc(count, atoms, &allocated);
  when("the getter of gain writes beyond the atoms", [&] { (*atoms)[1].a_w.w_long = 1; });
  atom_setfloat(*atoms, x->gain);
  return 0;
}
t_max_err set_gain(Small* x, void*, long count, t_atom* atoms) {
  if (count < 1 || atoms[0].a_type == A_SYM) {
    object_error(&x->header.z_ob, "gain: expected a number");
    return 0;
  }
  x->gain =
      atoms[0].a_type == A_FLOAT ? atoms[0].a_w.w_float : static_cast<double>(atoms[0].a_w.w_long);
  return 0;
}

/// The value of the box: gain, and what came to the middle inlet.
t_max_err get_value(Small* x, long* count, t_atom** atoms) {
  static t_atom own[2];
  char allocated = 0;
  if (provokes("getvalueof returns atoms that are not from atom_alloc_array") ||
      (provokes("getvalueof does not use the atoms that it was given") && *atoms)) {
    *count = 2;
    *atoms = own;
    return 0;
  }
  atom_alloc_array(provokes("atom_alloc_array: null instead of an address, or no atoms") ? 0 : 2,
                   count, atoms, &allocated);
  when("getvalueof returns more atoms than atom_alloc_array gave", [&] { *count = 3; });
  if (!*atoms)
    return -1;
  atom_setfloat(*atoms, x->gain);
  if (*count > 1 || provokes("getvalueof returns more atoms than it was given room for"))
    atom_setfloat(*atoms + 1, x->scalar);
  return 0;
}
t_max_err set_value(Small* x, long count, t_atom* atoms) {
  set_gain(x, nullptr, count, atoms);
  object_attr_touch(
      &x->header.z_ob,
      gensym(provokes("object_attr_touch: small~ a has no attribute gian") ? "gian" : "gain"));
  object_notify(x, gensym("modified"), nullptr);
  return 0;
}

// --- life ---

void free_small(Small* x) {
  if (provokes("z_dsp_free must come first in a free method: memory was freed before"))
    std::free(x->scratch);
  when("z_dsp_free must come first in a free method: object_free", [&] { object_free(x->clock); });
  if (!provokes("z_dsp_free was not called by the free method"))
    z_dsp_free(&x->header);
  if (!provokes("leak: clock of small~") &&
      !provokes("z_dsp_free must come first in a free method: object_free")) {
    if (!provokes("object_free: a clock that is armed"))
      clock_unset(x->clock);
    object_free(x->clock);
  }
  if (!provokes("leak: qelem of small~"))
    qelem_free(x->qelem);
  when("qelem_free: double free of qelem", [&] { qelem_free(x->qelem); });
  if (!provokes("leak: proxy of small~"))
    object_free(x->proxy);
  if (!provokes("leak: buffer_ref of small~"))
    object_free(x->buffer);
  when("clock_fdelay: use of a clock after it was freed", [&] { clock_fdelay(x->clock, 1); });
  when("z_dsp_free: twice", [&] { z_dsp_free(&x->header); });
  static Small* first = nullptr;
  if (provokes("write to small~ a after it was freed") && first)
    first->inlet_of_proxy = 1;
  first = x;
  when("outlet_bang: nothing can be sent from here", [&] { outlet_bang(x->message_outlet); });
  if (!provokes("z_dsp_free must come first in a free method: memory was freed before"))
    std::free(x->scratch);
}

void make_outlets(Small* x) {
  if (provokes("dumpout is the leftmost outlet")) {
    x->signal_outlet = outlet_new(x, "signal");
    x->message_outlet = outlet_new(x, nullptr);
    x->dumpout = outlet_new(x, nullptr);
  } else {
    x->dumpout = outlet_new(x, nullptr);
    x->message_outlet =
        outlet_new(x, provokes("outlet_new: no type of outlets: audio")           ? "audio"
                      : provokes("outlet_float: float to an outlet of type bang") ? "bang"
                                                                                  : nullptr);
    x->signal_outlet = outlet_new(
        x, provokes("outlet 0 is no signal outlet, but assist says: (signal) product") ? nullptr
                                                                                       : "signal");
  }
  object_obex_store(x, gensym("dumpout"), static_cast<t_object*>(x->dumpout));
}

void make_inlets(Small* x) {
  if (provokes("the constructor did not call z_dsp_setup"))
    return;
  const long signals =
      provokes("the proxies to the right begin with inlet 2, but there are 1 signal inlets") ? 1
                                                                                             : 2;
  when("proxy_new: small~: after z_dsp_setup", [&] { z_dsp_setup(&x->header, signals); });
  x->proxy = proxy_new(
      x, 2, provokes("no inlet, or nowhere to write its number") ? nullptr : &x->inlet_of_proxy);
  if (!provokes("proxy_new: small~: after z_dsp_setup"))
    z_dsp_setup(&x->header, signals);
  when("z_dsp_setup: small~: twice", [&] { z_dsp_setup(&x->header, signals); });
}

void* new_small(t_symbol*, long count, t_atom* atoms) {
  auto* x = static_cast<Small*>(object_alloc(small_class));
  x->gain = 1;
  x->scalar = 0;
  x->vectors = 0;
  x->connected[0] = x->connected[1] = false;
  x->planted = 1;
  x->inlet_of_proxy = 0;
  make_inlets(x);
  make_outlets(x);
  x->clock = clock_new(x, erased(on_clock));
  x->qelem = qelem_new(x, erased(on_qelem));
  x->buffer = buffer_ref_new(&x->header.z_ob, gensym("samples"));
  x->scratch = static_cast<double*>(std::malloc(64));
  if (provokes("object_free: double free of clock")) {
    stray_clock = clock_new(x, erased(on_clock));
    object_free(stray_clock);
  }
  if (!provokes("attributes among the arguments, but no attr_args_process"))
    attr_args_process(x, static_cast<short>(count), atoms);
  when("attr_args_process: twice", [&] { attr_args_process(x, static_cast<short>(count), atoms); });
  if (provokes("leak: atoms of small~")) {
    long one = 0;
    t_atom* leaked = nullptr;
    char allocated = 0;
    atom_alloc(&one, &leaked, &allocated);
  }
  when("the header of small~ was overwritten", [&] { x->header.z_ob.o_magic = 0; });
  if (provokes("did not free what it made and does not return"))
    return nullptr;
  return x;
}

/// Declarations that Max does not take.
void misdeclare(t_class* c) {
  if (provokes("A_GIMME and A_CANT stand alone"))
    class_addmethod(c, erased(bang), "other", A_CANT, A_LONG, 0);
  if (provokes("class_addmethod: small~: other: no function"))
    class_addmethod(c, nullptr, "other", 0);
  if (provokes("class_addmethod: small~: gain is an attribute too"))
    class_addmethod(c, erased(bang), "gain", 0);
  if (provokes("class_addattr: small~: bang is a method too"))
    class_addattr(c,
                  attribute_new("bang", gensym("float64"), 0, erased(get_gain), erased(set_gain)));
  if (provokes("attribute_new: other: no getter"))
    class_addattr(c, attribute_new("other", gensym("float64"), 0, nullptr, erased(set_gain)));
  if (provokes("attribute_new: other: no setter"))
    class_addattr(c, attribute_new("other", gensym("float64"), 0, erased(get_gain), nullptr));
  if (provokes("Max knows no property colour"))
    class_attr_addattr_parse(c, "gain", "colour", gensym("symbol"), 0, "red");
  when("class_dspinit: twice for small~", [&] { class_dspinit(c); });
}

void add_attribute(t_class* c) {
  t_object* gain = attribute_new(
      "gain", gensym(provokes("no type of attributes: double") ? "double" : "float64"), 0,
      erased(get_gain), erased(set_gain));
  if (provokes("leak: attribute other was added to no class"))
    attribute_new("other", gensym("float64"), 0, erased(get_gain), erased(set_gain));
  class_addattr(c, gain);
  when("class_addattr: small~: gain: it was added before", [&] { class_addattr(c, gain); });
  class_attr_addattr_parse(c, provokes("small~: gian is no attribute") ? "gian" : "gain", "save",
                           gensym("long"), 0, "1");
  class_attr_addattr_parse(c, "gain", "label", gensym("symbol"), 0, "Gain");
}
} // namespace

extern "C" MAX_EXPORT void ext_main(void*) {
  const std::size_t size = provokes("the struct is smaller than t_pxobject") ? sizeof(t_object)
                           : provokes("a write beyond its struct") ? sizeof(Small) - sizeof(double)
                                                                   : sizeof(Small);
  t_class* c =
      class_new(kName, erased(new_small),
                provokes("no free method, so no z_dsp_free") ? nullptr : erased(free_small),
                static_cast<long>(size), nullptr, A_GIMME, 0);
  if (!provokes("class_dspinit without a method dsp64"))
    class_addmethod(c, erased(dsp64), "dsp64",
                    provokes("dsp64 has other types than Max's") ? A_GIMME : A_CANT, 0);
  class_addmethod(c, erased(assist), "assist", A_CANT, 0);
  class_addmethod(c, erased(accepts_drag), "acceptsdrag_locked", A_CANT, 0);
  class_addmethod(c, erased(accepts_drag), "acceptsdrag_unlocked", A_CANT, 0);
  class_addmethod(c, erased(loadbang), "loadbang", A_CANT, 0);
  class_addmethod(c, erased(get_value), "getvalueof", A_CANT, 0);
  class_addmethod(c, erased(set_value), "setvalueof", A_CANT, 0);
  class_addmethod(c, erased(bang), "bang", 0);
  class_addmethod(c, erased(float_message), "float",
                  provokes("float has other types than Max's") ? A_LONG : A_FLOAT, 0);
  class_addmethod(c, erased(int_message), "int", A_LONG, 0);
  class_addmethod(c, erased(list), "list", A_GIMME, 0);
  class_addmethod(c, erased(anything), "anything", A_GIMME, 0);
  if (provokes("preset has other types than Max's"))
    class_addmethod(c, erased(anything), "preset", A_GIMME, 0);
  if (provokes("enable is a name that Max reserves"))
    class_addmethod(c, erased(bang), "enable", 0);
  if (provokes("Max calls no method of this name (A_CANT)"))
    class_addmethod(c, erased(bang), "loadbnag", A_CANT, 0);
  if (provokes("class_addmethod: small~: bang is there twice"))
    class_addmethod(c, erased(bang), "bang", 0);
  if (provokes("the types do not end with 0"))
    class_addmethod(c, erased(bang), "endless", A_LONG, A_LONG, A_LONG, A_LONG, A_LONG, A_LONG,
                    A_LONG, A_LONG, 0);
  add_attribute(c);
  if (!provokes("a method dsp64 without class_dspinit"))
    class_dspinit(c);
  misdeclare(c);
  if (provokes("registered no class"))
    return;
  class_register(gensym(provokes("in the name space boxes, expected box") ? "boxes" : "box"), c);
  if (provokes("class_register: small~: there is a class of this name"))
    class_register(gensym("box"), class_new(kName, erased(new_small), nullptr,
                                            static_cast<long>(size), nullptr, A_GIMME, 0));
  when("class_dspinit: after class_register of small~", [&] { class_dspinit(c); });
  if (provokes("class_addmethod: after class_register of small~"))
    class_addmethod(c, erased(bang), "late", 0);
  small_class = c;
}

// One small external, right as it stands, or wrong in the one respect that MISTAKE names:
// mistakes.txt says what the host must say of each.
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
bool wrong(std::string_view mistake) { return chosen && mistake == chosen; }
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
  if (wrong("outlet in perform"))
    outlet_float(x->message_outlet, 1);
  if (wrong("post in perform"))
    object_post(&x->header.z_ob, "performing");
  if (wrong("gensym in perform"))
    gensym("performing");
  if (wrong("critical region in perform")) {
    critical_enter(nullptr);
    critical_exit(nullptr);
  }
  if (wrong("allocation in perform")) {
    void* volatile memory = std::malloc(100);
    std::free(memory);
  }
  if (wrong("lock in perform"))
    hold_lock();
  if (wrong("proxy_getinlet in perform"))
    proxy_getinlet(&x->header.z_ob);
  if (wrong("exception in perform"))
    throw 1;
}

void perform(Small* x, t_object*, double** in, long inlets, double** out, long outlets, long n,
             long, void*) {
  misbehave(x);
  x->vectors.fetch_add(1, std::memory_order_relaxed);
  const bool muted = x->header.z_disabled != 0 && !wrong("mute is ignored");
  const bool connected =
      x->connected[1].load(std::memory_order_relaxed) || wrong("reads what is not connected");
  const bool silent = muted || !x->connected[0].load(std::memory_order_relaxed);
  const double scalar = x->scalar.load(std::memory_order_relaxed);
  double gain = x->gain.load(std::memory_order_relaxed);
  if (wrong("race"))
    gain = x->planted;
  const long length = wrong("writes past a vector")  ? n + 1
                      : wrong("leaves a sample out") ? n - 1
                                                     : n;
  for (long i = 0; i < length; ++i)
    out[0][i] = silent ? 0 : in[0][i] * (connected ? in[1][i] : scalar) * gain;
  if (wrong("writes before a vector"))
    out[0][-1] = 0;
  if (wrong("writes before an input"))
    in[0][-1] = 0;
  if (wrong("changes the table of vectors"))
    in[0] = nullptr;
  if (wrong("writes to an input"))
    in[0][0] = 2;
  if (wrong("reads past a vector"))
    x->scalar = in[0][n];
  if (wrong("reads an inlet too many"))
    x->scalar = in[inlets][0];
  if (wrong("writes an outlet too many"))
    out[outlets][0] = 0;
  qelem_set(x->qelem);
}

void dsp64(Small* x, t_object* chain, short* count, double, long, long) {
  for (std::size_t i = 0; i < 2; ++i)
    x->connected[i] = count[i] != 0;
  if (wrong("other chain"))
    chain = &x->header.z_ob;
  if (wrong("writes beyond the counts"))
    count[3] = 1;
  dsp_add64(chain, &x->header.z_ob,
            reinterpret_cast<t_perfroutine64>(reinterpret_cast<void (*)()>(perform)), 0, nullptr);
}

// --- messages ---

void float_message(Small* x, double value) {
  if (wrong("proxy_getinlet after an outlet"))
    outlet_float(x->message_outlet, value);
  const long inlet = proxy_getinlet(&x->header.z_ob);
  if (inlet == 1)
    x->scalar = value;
  if (wrong("race"))
    x->planted = value;
  qelem_set(x->qelem);
  if (wrong("critical region over an outlet"))
    critical_enter(nullptr);
  outlet_float(wrong("message to a signal outlet") ? x->signal_outlet : x->message_outlet, value);
  if (wrong("critical region over an outlet"))
    critical_exit(nullptr);
  if (wrong("critical region is kept"))
    critical_enter(nullptr);
  if (wrong("exit without enter"))
    critical_exit(nullptr);
}
void int_message(Small* x, t_atom_long value) { float_message(x, static_cast<double>(value)); }

void loadbang(Small* x) { outlet_bang(x->message_outlet); }

/// Calls that no object may make in a message.
void misuse(Small* x) {
  t_object own{};
  if (wrong("z_dsp_free in a message"))
    z_dsp_free(&x->header);
  if (wrong("class outside ext_main"))
    class_new("late~", erased(loadbang), nullptr, 100, nullptr, A_GIMME, 0);
  if (wrong("object_alloc in a message"))
    object_alloc(small_class);
  if (wrong("attr_args_process in a message"))
    attr_args_process(x, 0, nullptr);
  if (wrong("frees a proxy of z_dsp_setup"))
    object_free(x->header.z_proxy);
  if (wrong("frees an outlet"))
    object_free(x->message_outlet);
  if (wrong("posts for an object of its own"))
    object_post(&own, "hello");
  if (wrong("file of what is no patcher"))
    jpatcher_get_filepath(&x->header.z_ob);
  if (wrong("parent of what is no patcher"))
    jpatcher_get_parentpatcher(&x->header.z_ob);
  if (wrong("outlet as clock"))
    clock_fdelay(x->message_outlet, 1);
  if (wrong("outlet that Max did not give"))
    outlet_bang(x->scratch);
  if (wrong("null as outlet"))
    outlet_bang(nullptr);
  if (wrong("negative delay"))
    clock_fdelay(x->clock, -1);
  if (wrong("critical region of its own"))
    critical_enter(reinterpret_cast<t_critical>(x));
  if (wrong("negative count of atoms"))
    outlet_list(x->message_outlet, nullptr, -1, nullptr);
  if (wrong("list with a selector"))
    outlet_list(x->message_outlet, gensym("words"), 0, nullptr);
  if (wrong("buffer unlocked twice"))
    if (t_buffer_obj* samples = buffer_ref_getobject(x->buffer))
      buffer_unlocksamples(samples);
  if (wrong("null where null is not allowed")) {
    gensym(nullptr);
    clock_getftime(nullptr);
    atom_alloc(nullptr, nullptr, nullptr);
    qelem_new(x, nullptr);
  }
}

void bang(Small* x) {
  misuse(x);
  clock_fdelay(x->clock, 5);
  if (wrong("double free"))
    object_free(stray_clock);
  if (wrong("frees what Max did not give"))
    object_free(x->scratch);
  if (wrong("frees its own box"))
    object_free(x);
  if (wrong("outlet after construction"))
    outlet_new(x, nullptr);
  if (wrong("dsp_add64 outside dsp64"))
    dsp_add64(&x->header.z_ob, &x->header.z_ob,
              reinterpret_cast<t_perfroutine64>(reinterpret_cast<void (*)()>(perform)), 0, nullptr);
  if (wrong("outlet from its own thread"))
    std::thread([x] { outlet_bang(x->message_outlet); }).join();
  if (wrong("buffer stays locked"))
    if (t_buffer_obj* samples = buffer_ref_getobject(x->buffer))
      buffer_locksamples(samples);
  if (wrong("reads past a buffer"))
    if (t_buffer_obj* samples = buffer_ref_getobject(x->buffer)) {
      const float* first = buffer_locksamples(samples);
      x->scalar = static_cast<double>(
          first[buffer_getframecount(samples) * buffer_getchannelcount(samples)]);
      buffer_unlocksamples(samples);
    }
}

void list(Small* x, t_symbol*, long count, t_atom* atoms) {
  if (wrong("atom of no type") && count > 0)
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
  path_topathname(wrong("path that Max did not give") ? 99 : folder, name, found);
  path_nameconform(found, path, wrong("no style of paths") ? 9 : PATH_STYLE_SLASH,
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
  if (wrong("exception in a message"))
    throw 1;
  outlet_anything(x->message_outlet, wrong("symbol of its own") ? &own : s,
                  static_cast<short>(count), atoms);
}
void on_clock(Small* x) {
  if (wrong("proxy_getinlet in a clock"))
    proxy_getinlet(&x->header.z_ob);
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
  if (wrong("assist too long"))
    std::snprintf(text, 300, "%0256d", 0); // 256 characters and the zero
}

t_atom_long accepts_drag(Small* x, t_object* drag, t_object*) {
  if (wrong("accepts a drag without a message"))
    return 1;
  t_object other{};
  jdrag_object_add(wrong("drag of its own") ? &other : drag,
                   wrong("drag for another object") ? static_cast<t_object*>(x->clock)
                                                    : &x->header.z_ob,
                   gensym(wrong("drag to no message") ? "assist" : "find"));
  return wrong("refuses a drag that it named a message for") ? 0 : 1;
}

t_max_err get_gain(Small* x, void*, long* count, t_atom** atoms) {
  static t_atom own;
  char allocated = 0;
  if (wrong("getter without atom_alloc") || (wrong("getter ignores given atoms") && *atoms)) {
    *count = 1;
    *atoms = &own;
  } else
    atom_alloc(count, atoms, &allocated);
  if (wrong("getter writes too much"))
    (*atoms)[1].a_w.w_long = 1;
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
  if (wrong("value without atom_alloc_array") || (wrong("value ignores given atoms") && *atoms)) {
    *count = 2;
    *atoms = own;
    return 0;
  }
  atom_alloc_array(wrong("value of no atoms") ? 0 : 2, count, atoms, &allocated);
  if (wrong("value beyond its atoms"))
    *count = 3;
  if (!*atoms)
    return -1;
  atom_setfloat(*atoms, x->gain);
  if (*count > 1 || wrong("value beyond given atoms"))
    atom_setfloat(*atoms + 1, x->scalar);
  return 0;
}
t_max_err set_value(Small* x, long count, t_atom* atoms) {
  set_gain(x, nullptr, count, atoms);
  object_attr_touch(&x->header.z_ob, gensym(wrong("touches no attribute") ? "gian" : "gain"));
  object_notify(x, gensym("modified"), nullptr);
  return 0;
}

// --- life ---

void free_small(Small* x) {
  if (wrong("memory freed before z_dsp_free"))
    std::free(x->scratch);
  if (wrong("clock freed before z_dsp_free"))
    object_free(x->clock);
  if (!wrong("no z_dsp_free"))
    z_dsp_free(&x->header);
  if (!wrong("clock leaks") && !wrong("clock freed before z_dsp_free")) {
    if (!wrong("armed clock freed"))
      clock_unset(x->clock);
    object_free(x->clock);
  }
  if (!wrong("qelem leaks"))
    qelem_free(x->qelem);
  if (wrong("qelem freed twice"))
    qelem_free(x->qelem);
  if (!wrong("proxy leaks"))
    object_free(x->proxy);
  if (!wrong("buffer reference leaks"))
    object_free(x->buffer);
  if (wrong("clock used after free"))
    clock_fdelay(x->clock, 1);
  if (wrong("z_dsp_free twice"))
    z_dsp_free(&x->header);
  static Small* first = nullptr;
  if (wrong("writes to freed memory") && first)
    first->inlet_of_proxy = 1;
  first = x;
  if (wrong("outlet in the free method"))
    outlet_bang(x->message_outlet);
  if (!wrong("memory freed before z_dsp_free"))
    std::free(x->scratch);
}

void make_outlets(Small* x) {
  if (wrong("outlets from left to right")) {
    x->signal_outlet = outlet_new(x, "signal");
    x->message_outlet = outlet_new(x, nullptr);
    x->dumpout = outlet_new(x, nullptr);
  } else {
    x->dumpout = outlet_new(x, nullptr);
    x->message_outlet = outlet_new(x, wrong("outlet of no type")      ? "audio"
                                      : wrong("outlet of other type") ? "bang"
                                                                      : nullptr);
    x->signal_outlet = outlet_new(x, wrong("outlet without signal") ? nullptr : "signal");
  }
  object_obex_store(x, gensym("dumpout"), static_cast<t_object*>(x->dumpout));
}

void make_inlets(Small* x) {
  if (wrong("no z_dsp_setup"))
    return;
  const long signals = wrong("too few signal inlets") ? 1 : 2;
  if (wrong("proxy after z_dsp_setup"))
    z_dsp_setup(&x->header, signals);
  x->proxy = proxy_new(x, 2, wrong("proxy without an address") ? nullptr : &x->inlet_of_proxy);
  if (!wrong("proxy after z_dsp_setup"))
    z_dsp_setup(&x->header, signals);
  if (wrong("z_dsp_setup twice"))
    z_dsp_setup(&x->header, signals);
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
  if (wrong("double free")) {
    stray_clock = clock_new(x, erased(on_clock));
    object_free(stray_clock);
  }
  if (!wrong("attributes are not processed"))
    attr_args_process(x, static_cast<short>(count), atoms);
  if (wrong("attributes are processed twice"))
    attr_args_process(x, static_cast<short>(count), atoms);
  if (wrong("atoms leak")) {
    long one = 0;
    t_atom* leaked = nullptr;
    char allocated = 0;
    atom_alloc(&one, &leaked, &allocated);
  }
  if (wrong("overwrites its header"))
    x->header.z_ob.o_magic = 0;
  if (wrong("returns nothing"))
    return nullptr;
  return x;
}

/// Declarations that Max does not take.
void misdeclare(t_class* c) {
  if (wrong("A_CANT not alone"))
    class_addmethod(c, erased(bang), "other", A_CANT, A_LONG, 0);
  if (wrong("method without a function"))
    class_addmethod(c, nullptr, "other", 0);
  if (wrong("method as the attribute"))
    class_addmethod(c, erased(bang), "gain", 0);
  if (wrong("attribute as the method"))
    class_addattr(c,
                  attribute_new("bang", gensym("float64"), 0, erased(get_gain), erased(set_gain)));
  if (wrong("attribute without a getter"))
    class_addattr(c, attribute_new("other", gensym("float64"), 0, nullptr, erased(set_gain)));
  if (wrong("attribute without a setter"))
    class_addattr(c, attribute_new("other", gensym("float64"), 0, erased(get_gain), nullptr));
  if (wrong("property that Max does not know"))
    class_attr_addattr_parse(c, "gain", "colour", gensym("symbol"), 0, "red");
  if (wrong("class_dspinit twice"))
    class_dspinit(c);
}

void add_attribute(t_class* c) {
  t_object* gain =
      attribute_new("gain", gensym(wrong("attribute of no type") ? "double" : "float64"), 0,
                    erased(get_gain), erased(set_gain));
  if (wrong("attribute leaks"))
    attribute_new("other", gensym("float64"), 0, erased(get_gain), erased(set_gain));
  class_addattr(c, gain);
  if (wrong("attribute twice"))
    class_addattr(c, gain);
  class_attr_addattr_parse(c, wrong("property of no attribute") ? "gian" : "gain", "save",
                           gensym("long"), 0, "1");
  class_attr_addattr_parse(c, "gain", "label", gensym("symbol"), 0, "Gain");
}
} // namespace

extern "C" MAX_EXPORT void ext_main(void*) {
  const std::size_t size = wrong("struct smaller than t_pxobject") ? sizeof(t_object)
                           : wrong("struct too small")             ? sizeof(Small) - sizeof(double)
                                                                   : sizeof(Small);
  t_class* c =
      class_new(kName, erased(new_small), wrong("no free method") ? nullptr : erased(free_small),
                static_cast<long>(size), nullptr, A_GIMME, 0);
  if (!wrong("no dsp64"))
    class_addmethod(c, erased(dsp64), "dsp64", wrong("other types than Max's") ? A_GIMME : A_CANT,
                    0);
  class_addmethod(c, erased(assist), "assist", A_CANT, 0);
  class_addmethod(c, erased(accepts_drag), "acceptsdrag_locked", A_CANT, 0);
  class_addmethod(c, erased(accepts_drag), "acceptsdrag_unlocked", A_CANT, 0);
  class_addmethod(c, erased(loadbang), "loadbang", A_CANT, 0);
  class_addmethod(c, erased(get_value), "getvalueof", A_CANT, 0);
  class_addmethod(c, erased(set_value), "setvalueof", A_CANT, 0);
  class_addmethod(c, erased(bang), "bang", 0);
  class_addmethod(c, erased(float_message), "float", wrong("float as int") ? A_LONG : A_FLOAT, 0);
  class_addmethod(c, erased(int_message), "int", A_LONG, 0);
  class_addmethod(c, erased(list), "list", A_GIMME, 0);
  class_addmethod(c, erased(anything), "anything", A_GIMME, 0);
  if (wrong("preset with arguments"))
    class_addmethod(c, erased(anything), "preset", A_GIMME, 0);
  if (wrong("reserved name"))
    class_addmethod(c, erased(bang), "enable", 0);
  if (wrong("unknown method of Max"))
    class_addmethod(c, erased(bang), "loadbnag", A_CANT, 0);
  if (wrong("method twice"))
    class_addmethod(c, erased(bang), "bang", 0);
  if (wrong("types without end"))
    class_addmethod(c, erased(bang), "endless", A_LONG, A_LONG, A_LONG, A_LONG, A_LONG, A_LONG,
                    A_LONG, A_LONG, 0);
  add_attribute(c);
  if (!wrong("no class_dspinit"))
    class_dspinit(c);
  misdeclare(c);
  if (wrong("registers no class"))
    return;
  class_register(gensym(wrong("other name space") ? "boxes" : "box"), c);
  if (wrong("class twice"))
    class_register(gensym("box"), class_new(kName, erased(new_small), nullptr,
                                            static_cast<long>(size), nullptr, A_GIMME, 0));
  if (wrong("class_dspinit after class_register"))
    class_dspinit(c);
  if (wrong("method after class_register"))
    class_addmethod(c, erased(bang), "late", 0);
  small_class = c;
}

#include "max/shell/max_object.hpp"

#include "core/declaration_text.hpp"
#include "max/abi/max_abi.h"
#include "max/shell/atoms.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tactus::max {
namespace {

constexpr std::size_t kMaxAssistance = 256; // size of Max's buffer with the final zero

/// The class of this module.
struct {
  t_class* handle;
  const ModuleObject<double>* module;
  InstanceNumbers numbers;
} the_class{};

bool processes() { return the_class.module->traits.processes; }

const Message* file_message(const Declaration& declaration) {
  const auto found = std::find_if(declaration.messages.begin(), declaration.messages.end(),
                                  [](const Message& message) { return message.file; });
  return found == declaration.messages.end() ? nullptr : &*found;
}

void destroy(Instance* instance) {
  // Only a constructed object is part of the signal chain.
  if (instance->self && processes())
    z_dsp_free(&instance->object);
  delete instance->self;
  instance->self = nullptr;
}

void* create(t_symbol*, long count, t_atom* atoms) {
  auto* instance = static_cast<Instance*>(object_alloc(the_class.handle));
  if (!instance)
    return nullptr;
  instance->self = nullptr;
  bool begun = false;
  tactus::guarded(
      [&] { instance->self = new MaxObject(*instance, *the_class.module, the_class.numbers); },
      [&](const char* why) { object_error(&instance->object.z_ob, "%s", why); });
  guarded(instance, [&](MaxObject& object) { begun = object.begin(to_atoms(count, atoms)); });
  if (begun)
    return instance;
  object_free(instance);
  return nullptr;
}

std::size_t inlet_of(Instance* instance) {
  return static_cast<std::size_t>(std::max(proxy_getinlet(&instance->object.z_ob), 0L));
}

// The inlet is read first, since any output may change it.
void on_float(Instance* instance, double value) {
  const std::size_t inlet = inlet_of(instance);
  guarded(instance, [&](MaxObject& object) { object.number(inlet, value); });
}
void on_int(Instance* instance, t_atom_long value) {
  on_float(instance, static_cast<double>(value));
}
void on_list(Instance* instance, t_symbol*, long count, t_atom* atoms) {
  const std::size_t inlet = inlet_of(instance);
  guarded(instance, [&](MaxObject& object) { object.list(inlet, to_atoms(count, atoms)); });
}
void on_bang(Instance* instance) {
  guarded(instance, [](MaxObject& object) { object.message("bang", {}); });
}
void on_message(Instance* instance, t_symbol* selector, long count, t_atom* atoms) {
  guarded(instance,
          [&](MaxObject& object) { object.message(selector->s_name, to_atoms(count, atoms)); });
}
/// `symbol reset` is the message reset.
void on_symbol(Instance* instance, t_symbol* word) { on_message(instance, word, 0, nullptr); }

void on_assist(Instance* instance, void*, long direction, long index, char* text) {
  text[0] = '\0';
  guarded(instance, [&](const MaxObject& object) {
    const std::string words = assistance(object.declaration(), direction == ASSIST_INLET,
                                         static_cast<std::size_t>(std::max(index, 0L)));
    const std::size_t size = std::min(words.size(), kMaxAssistance - 1);
    std::copy_n(words.begin(), size, text);
    text[size] = '\0';
  });
}

/// Whether a file may be dropped onto the box. Max then sends it to the first message that takes a
/// file. The message itself checks the file and reports errors.
t_atom_long on_drag(Instance* instance, t_object* drag, t_object*) {
  guarded(instance, [&](const MaxObject& object) {
    jdrag_object_add(drag, &instance->object.z_ob,
                     symbol_of(file_message(object.declaration())->name));
  });
  return 1;
}

// Nine arguments, as Max declares a perform routine.
void on_perform(t_object* object, t_object*, double** in, long in_count, double** out,
                long out_count, long frames, long, void*) {
  auto* instance = reinterpret_cast<Instance*>(object);
  instance->self->perform({in, static_cast<std::size_t>(in_count)},
                          {out, static_cast<std::size_t>(out_count)},
                          static_cast<std::size_t>(frames));
}
void on_dsp(Instance* instance, t_object* chain, short* counts, double sample_rate, long max_frames,
            long) {
  guarded(instance, [&](MaxObject& object) {
    object.prepare({counts, count_signal_inlets(object.declaration())}, sample_rate, max_frames);
    dsp_add64(chain, &instance->object.z_ob, &on_perform, 0, nullptr);
  });
}

void add_messages(t_class* handle, const Declaration& declaration) {
  const auto add = [handle](std::string_view name) {
    class_addmethod(handle, method_of(&on_message), std::string(name).c_str(), A_GIMME, 0);
  };
  class_addmethod(handle, method_of(&on_int), "int", A_LONG, 0);
  class_addmethod(handle, method_of(&on_float), "float", A_FLOAT, 0);
  class_addmethod(handle, method_of(&on_list), "list", A_GIMME, 0);
  class_addmethod(handle, method_of(&on_bang), "bang", 0);
  class_addmethod(handle, method_of(&on_symbol), "symbol", A_SYM, 0);
  // Max's preset object calls a method named preset with the object as its only argument, so a
  // message of that name is handled by "anything".
  for (const Message& message : declaration.messages)
    if (message.name != "list" && message.name != "bang" && message.name != "preset")
      add(message.name);
  for (const std::string_view name : {"get", "dump", "anything"})
    add(name);
}

// --- attributes ---

constexpr std::size_t kMaxParameters = 96;

t_max_err set_parameter(Instance* instance, std::size_t index, long count, const t_atom* atoms) {
  guarded(instance, [&](MaxObject& object) {
    object.message(object.declaration().parameters[index].name, to_atoms(count, atoms));
  });
  return 0; // a refused value has been reported; the old value remains
}

t_max_err get_parameter(Instance* instance, std::size_t index, long* count, t_atom** atoms) {
  char was_allocated = 0;
  if (const t_max_err failed = atom_alloc(count, atoms, &was_allocated); failed != 0)
    return failed;
  guarded(instance, [&](const MaxObject& object) { set_atom(**atoms, object.parameter(index)); });
  return 0;
}

std::vector<std::size_t> stored_parameters(const Declaration& declaration) {
  std::vector<std::size_t> stored;
  for (std::size_t i = 0; i < declaration.parameters.size(); ++i)
    if (declaration.parameters[i].stored)
      stored.push_back(i);
  return stored;
}

// The value of the whole box for pattr, autopattr and pattrstorage: the values of all parameters
// that a host may store.
t_max_err get_value(Instance* instance, long* count, t_atom** atoms) {
  guarded(instance, [&](const MaxObject& object) {
    const std::vector<std::size_t> stored = stored_parameters(object.declaration());
    const auto size = static_cast<long>(stored.size());
    char was_allocated = 0;
    if (atom_alloc_array(size, count, atoms, &was_allocated) != 0)
      return;
    *count = was_allocated ? size : std::min(*count, size); // writes no more than the caller's
                                                            // memory holds
    for (long i = 0; i < *count; ++i)
      set_atom((*atoms)[i], object.parameter(stored[static_cast<std::size_t>(i)]));
  });
  return 0;
}
t_max_err set_value(Instance* instance, long count, t_atom* atoms) {
  guarded(instance, [&](MaxObject& object) {
    const std::vector<std::size_t> stored = stored_parameters(object.declaration());
    const std::vector<Atom> values = to_atoms(count, atoms);
    if (values.size() > stored.size())
      throw std::invalid_argument("the stored value has " + std::to_string(values.size()) +
                                  " numbers: expected at most " + std::to_string(stored.size()) +
                                  ", one for each parameter");
    for (std::size_t i = 0; i < values.size(); ++i)
      object.message(object.declaration().parameters[stored[i]].name, {values[i]});
  });
  return 0;
}

// Max passes the attribute to a setter as an object, whose name only a variadic function can read.
// So each parameter gets its own functions.
template <std::size_t index> t_max_err set(Instance* instance, void*, long count, t_atom* atoms) {
  return set_parameter(instance, index, count, atoms);
}
template <std::size_t index> t_max_err get(Instance* instance, void*, long* count, t_atom** atoms) {
  return get_parameter(instance, index, count, atoms);
}
struct Accessors {
  t_max_err (*get)(Instance*, void*, long*, t_atom**);
  t_max_err (*set)(Instance*, void*, long, t_atom*);
};
template <std::size_t... index>
constexpr std::array<Accessors, sizeof...(index)> accessors(std::index_sequence<index...>) {
  return {{{&get<index>, &set<index>}...}};
}
constexpr auto kAccessors = accessors(std::make_index_sequence<kMaxParameters>{});

std::string in_quotes(std::string_view text) { return '"' + std::string(text) + '"'; }

/// The labels of an enumeration; empty for an ordinary number.
std::string menu(const Parameter& parameter) {
  std::string words;
  for (const std::string_view choice : parameter.choices)
    words += (words.empty() ? "" : " ") + std::string(choice);
  for (const double value : parameter.values)
    words += (words.empty() ? "" : " ") + number_text(value);
  return words;
}

/// Adds an attribute for each parameter: @name in the box, the inspector, `name value`, `getname`,
/// presets and pattr. The object stores the value; setters and getters access it. The value of the
/// whole box is the list of all parameters.
void add_attributes(t_class* handle, const Declaration& declaration) {
  if (declaration.parameters.size() > kMaxParameters)
    throw std::length_error("more parameters than kMaxParameters");
  if (!stored_parameters(declaration).empty()) {
    class_addmethod(handle, method_of(&get_value), "getvalueof", A_CANT, 0);
    class_addmethod(handle, method_of(&set_value), "setvalueof", A_CANT, 0);
  }
  for (std::size_t i = 0; i < declaration.parameters.size(); ++i) {
    const Parameter& parameter = declaration.parameters[i];
    const std::string name(parameter.name);
    const char* type = parameter.choices.empty() ? "float64" : "symbol";
    class_addattr(handle, attribute_new(name.c_str(), gensym(type), 0, method_of(kAccessors[i].get),
                                        method_of(kAccessors[i].set)));
    const auto describe = [&](const char* what, const char* kind, const std::string& text) {
      class_attr_addattr_parse(handle, name.c_str(), what, gensym(kind), 0, text.c_str());
    };
    describe(
        "label", "symbol",
        in_quotes(parameter.unit.empty() ? name : name + " (" + std::string(parameter.unit) + ")"));
    describe("category", "symbol", "Parameters");
    describe("order", "long", std::to_string(i + 1));
    if (parameter.stored)
      describe("save", "long", "1");
    if (const std::string words = menu(parameter); !words.empty()) {
      describe("style", "symbol", "enum");
      describe("enumvals", "atom", words);
    }
  }
}

} // namespace

void register_class(const ModuleObject<double>& module) {
  const Declaration& declaration = *module.traits.declaration;
  t_class* handle = class_new(std::string(declaration.name).c_str(), method_of(&create),
                              method_of(&destroy), sizeof(Instance), nullptr, A_GIMME, 0);
  the_class.handle = handle;
  the_class.module = &module;
  add_messages(handle, declaration);
  add_attributes(handle, declaration);
  class_addmethod(handle, method_of(&on_assist), "assist", A_CANT, 0);
  if (file_message(declaration))
    for (const char* name : {"acceptsdrag_locked", "acceptsdrag_unlocked"})
      class_addmethod(handle, method_of(&on_drag), name, A_CANT, 0);
  if (module.traits.processes) {
    class_addmethod(handle, method_of(&on_dsp), "dsp64", A_CANT, 0);
    class_dspinit(handle);
  }
  class_register(gensym("box"), handle);
}

} // namespace tactus::max

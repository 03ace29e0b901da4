// Messages and attributes on their way to an object.
#include "max/stub/audio.hpp"
#include "max/stub/kernel.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace tactus::stub {
namespace {
constexpr std::size_t kMaxTyped = 4; // arguments of a typed method

template <class... Done>
void* call_with(method function, void* x, std::span<const t_atom> rest, Done... done) {
  if (rest.empty())
    return as<void* (*)(void*, Done...)>(function)(x, done...);
  if constexpr (sizeof...(Done) < kMaxTyped) {
    const t_atom& next = rest.front();
    if (next.a_type == A_FLOAT)
      return call_with(function, x, rest.subspan(1), done..., next.a_w.w_float);
    return call_with(function, x, rest.subspan(1), done..., next.a_w.w_long);
  }
  return nullptr;
}

/// The atoms as a typed method wants them; false if they do not fit.
bool convert(const std::vector<short>& types, std::span<const t_atom> given,
             std::vector<t_atom>& arguments) {
  if (given.size() > types.size())
    return false;
  for (std::size_t i = 0; i < types.size(); ++i) {
    const bool present = i < given.size();
    if (!present && types[i] < A_DEFLONG)
      return false;
    const t_atom a = present ? given[i] : long_atom(0);
    const bool number = a.a_type == A_LONG || a.a_type == A_FLOAT;
    const double value = a.a_type == A_FLOAT ? a.a_w.w_float : static_cast<double>(a.a_w.w_long);
    switch (types[i]) {
    case A_LONG:
    case A_DEFLONG:
      if (!number)
        return false;
      arguments.push_back(a.a_type == A_LONG ? a : long_atom(static_cast<t_atom_long>(value)));
      break;
    case A_FLOAT:
    case A_DEFFLOAT:
      if (!number)
        return false;
      arguments.push_back(float_atom(value));
      break;
    default:
      if (present && a.a_type != A_SYM)
        return false;
      arguments.push_back(present ? a : symbol_atom(""));
    }
  }
  return true;
}

/// Calls a message's method. What it is given is in memory that ends with a guard.
void call_method(Object& object, const Method& m, Call& call, std::string_view selector,
                 std::span<t_atom> atoms) {
  void* x = object.header();
  if (m.types == std::vector<short>{A_CANT}) {
    print_error(&object, "doesn't understand \"" + std::string(selector) + "\"");
    return;
  }
  if (m.types == std::vector<short>{A_GIMME}) {
    run_external(call, [&] {
      as<void* (*)(void*, t_symbol*, long, t_atom*)>(m.function)(
          x, symbol(selector), static_cast<long>(atoms.size()), atoms.data());
    });
    return;
  }
  std::vector<t_atom> arguments;
  if (!convert(m.types, atoms, arguments)) {
    print_error(&object, "bad arguments for message \"" + std::string(selector) + "\"");
    return;
  }
  run_external(call, [&] { call_with(m.function, x, arguments); });
}

/// The method for a message: its own, or those that Max falls back to.
const Method* find_method(const t_class& c, std::string_view& selector, std::span<t_atom> atoms) {
  if (const Method* own = c.find(selector))
    return own;
  if (selector == "list" && atoms.size() == 1 && atoms[0].a_type != A_SYM) {
    selector = atoms[0].a_type == A_LONG ? "int" : "float";
    if (const Method* number = c.find(selector))
      return number;
  }
  if (selector == "int" || selector == "float")
    if (const Method* number = c.find(selector == "int" ? "float" : "int"))
      return number;
  return c.find("anything");
}

bool set_by_message(Object& object, std::string_view selector, std::span<t_atom> atoms) {
  if (object.type->attribute(selector)) {
    set_attribute(object, selector, atoms);
    return true;
  }
  if (selector.substr(0, 3) != "get")
    return false;
  const Attribute* attribute = object.type->attribute(selector.substr(3));
  if (!attribute)
    return false;
  std::vector<t_atom> value = get_attribute(object, *attribute);
  const auto dumpout = object.obex.find(symbol("dumpout"));
  if (dumpout != object.obex.end()) {
    Call call{.where = Where::kMessage, .object = &object, .name = selector};
    const Entered entered(call);
    const HostWork work;
    outlet_anything(dumpout->second, symbol(attribute->name), static_cast<short>(value.size()),
                    value.data());
  }
  return true;
}
} // namespace

void print_error(const Object* object, const std::string& text) {
  print_line("error: " + (object ? object->text() : "max") + ": " + text);
}

void send_message(Object& object, long inlet, std::string_view selector, std::span<t_atom> atoms) {
  const HostWork work;
  if (!require_object(object.header(), "a message"))
    return;
  if (inlet < 0 || inlet >= object.inlets()) {
    print_error(&object, "has no inlet " + std::to_string(inlet));
    return;
  }
  std::string_view name = selector;
  const Method* m = object.type->find(name);
  if (!m && set_by_message(object, selector, atoms))
    return;
  if (!m)
    m = find_method(*object.type, name, atoms);
  if (!m) {
    print_error(&object, "doesn't understand \"" + std::string(selector) + "\"");
    return;
  }
  long* number = nullptr;
  for (const Proxy* proxy : object.proxies)
    if (proxy->id == inlet)
      number = proxy->inlet;
  if (number)
    __atomic_store_n(number, inlet, __ATOMIC_RELAXED);
  Call call{.where = Where::kMessage,
            .object = &object,
            .name = selector,
            .inlet = inlet,
            .has_inlet = true};
  call_method(object, *m, call, name, atoms);
  if (number && object.alive)
    __atomic_store_n(number, 0, __ATOMIC_RELAXED);
  if (object.alive)
    require_object(object.header(), "after a message");
}

bool set_attribute(Object& object, std::string_view name, std::span<t_atom> atoms) {
  const HostWork work;
  const Attribute* a = object.type->attribute(name);
  if (!a || !a->setter || (a->flags & 0x202) != 0) {
    print_error(&object, std::string(name) + (a ? " cannot be set" : " is not an attribute"));
    return false;
  }
  Call call{.where = Where::kSetter, .object = &object, .name = a->name};
  if (const Call* outer = current_call(); outer && outer->object == &object)
    call.inlet = outer->inlet;
  t_max_err error = 0;
  std::vector<t_atom> copy(atoms.begin(), atoms.end());
  run_external(call, [&] {
    error = as<t_max_err (*)(void*, void*, long, t_atom*)>(a->setter)(
        object.header(), const_cast<Attribute*>(a), static_cast<long>(copy.size()), copy.data());
  });
  if (error)
    print_error(&object, std::string(name) + ": the setter returns an error");
  return true;
}

namespace {
using Getter = t_max_err (*)(void*, void*, long*, t_atom**);

/// Asks with memory of the host's: one atom, and a guard behind it.
std::vector<t_atom> ask_into_memory(Object& object, const Attribute& a) {
  const Block memory(sizeof(t_atom));
  long count = 1;
  auto* atoms = reinterpret_cast<t_atom*>(memory.data());
  *atoms = long_atom(0);
  Call call{.where = Where::kGetter, .object = &object, .name = a.name};
  run_external(call, [&] {
    as<Getter>(a.getter)(object.header(), const_cast<Attribute*>(&a), &count, &atoms);
  });
  if (!memory.guards_intact())
    violation("the getter of " + a.name + " writes beyond the atoms that it was given");
  if (reinterpret_cast<std::byte*>(atoms) != memory.data())
    violation("the getter of " + a.name +
              " does not use the atoms that it was given: use atom_alloc");
  else if (check_atoms(count, atoms, "a getter"))
    return {atoms, atoms + std::clamp(count, 0L, 1L)};
  return {};
}
} // namespace

std::vector<t_atom> get_attribute(Object& object, const Attribute& a) {
  const HostWork work;
  if (!a.getter)
    return {};
  long count = 0;
  t_atom* atoms = nullptr;
  t_max_err error = 0;
  Call call{.where = Where::kGetter, .object = &object, .name = a.name};
  run_external(call, [&] {
    error = as<Getter>(a.getter)(object.header(), const_cast<Attribute*>(&a), &count, &atoms);
  });
  if (error || count < 1 || !atoms)
    return {};
  Record* record = find_record(atoms);
  if (!record || record->kind != Kind::kAtoms || !record->alive) {
    violation("the getter of " + a.name + " returns atoms that are not from atom_alloc");
    return {};
  }
  record->alive = false;
  std::vector<t_atom> value;
  if (count == 1 && check_atoms(count, atoms, "a getter"))
    value.assign(atoms, atoms + count);
  else if (count != 1)
    violation("the getter of " + a.name + " returns more atoms than atom_alloc gave");
  if (!static_cast<Atoms*>(record)->block.guards_intact())
    violation("the getter of " + a.name + " writes beyond the atoms of atom_alloc");
  ask_into_memory(object, a);
  return value;
}

std::string assist_text(Object& object, long direction, long index) {
  constexpr std::size_t kSize = 256, kGuard = 512;
  const Method* assist = object.type->find("assist");
  if (!assist)
    return {};
  std::array<char, kSize + kGuard> text{};
  std::fill(text.begin() + kSize, text.end(), '\x5A');
  Call call{.where = Where::kAssist, .object = &object};
  run_external(call, [&] {
    as<void (*)(void*, void*, long, long, char*)>(assist->function)(object.header(), nullptr,
                                                                    direction, index, text.data());
  });
  if (std::any_of(text.begin() + kSize, text.end(), [](char c) { return c != '\x5A'; }))
    violation("assist writes more than 256 characters, with the zero");
  text[kSize - 1] = '\0';
  return text.data();
}

namespace {
/// Where the attribute arguments begin.
long attributes_offset(long count, const t_atom* atoms) {
  for (long i = 0; i < count; ++i)
    if (atoms[i].a_type == A_SYM && name_of(atoms[i].a_w.w_sym).substr(0, 1) == "@")
      return i;
  return count;
}
} // namespace

} // namespace tactus::stub

using namespace tactus::stub;

void attr_args_process(void* x, short count, t_atom* atoms) {
  const ApiCall api("attr_args_process", static_cast<unsigned>(Role::kMain));
  Object* object = require_object(x, "attr_args_process");
  if (!object || !check_atoms(count, atoms, "attr_args_process"))
    return;
  if (object->constructed)
    violation("attr_args_process: outside the constructor");
  if (object->attributes_processed)
    violation("attr_args_process: twice");
  object->attributes_processed = true;
  for (long i = attributes_offset(count, atoms); i < count;) {
    const std::string_view name = name_of(atoms[i].a_w.w_sym).substr(1);
    long end = i + 1;
    end += attributes_offset(count - end, atoms + end);
    if (object->type->attribute(name))
      set_attribute(*object, name, {atoms + i + 1, static_cast<std::size_t>(end - i - 1)});
    else
      print_error(object, "\"" + std::string(name) + "\" is not a valid attribute argument");
    i = end;
  }
}

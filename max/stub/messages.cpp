// Sends messages, attributes and other queries to an object.
#include "max/stub/stub.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace tactus::stub {
namespace {
/// Calls a message's method with arguments of its types; false if they do not fit.
bool call_method(void* x, const t_class::Method& m, std::string_view selector,
                 std::span<t_atom> atoms) {
  if (m.types == std::vector<short>{A_GIMME}) {
    as<void (*)(void*, t_symbol*, long, t_atom*)>(m.function)(
        x, symbol(selector), static_cast<long>(atoms.size()), atoms.data());
    return true;
  }
  if (m.types.size() != atoms.size())
    return false;
  if (m.types.empty()) {
    as<void (*)(void*)>(m.function)(x);
    return true;
  }
  const t_atom& a = atoms[0];
  const double number = a.a_type == A_FLOAT ? a.a_w.w_float : static_cast<double>(a.a_w.w_long);
  const short type = m.types[0];
  if (type == A_CANT || (type == A_SYM) != (a.a_type == A_SYM))
    return false;
  if (type == A_SYM)
    as<void (*)(void*, t_symbol*)>(m.function)(x, a.a_w.w_sym);
  else if (type == A_LONG)
    as<void (*)(void*, t_atom_long)>(m.function)(x, static_cast<t_atom_long>(number));
  else
    as<void (*)(void*, double)>(m.function)(x, number);
  return true;
}

/// Handles `NAME value` of an attribute, and `getNAME`, whose answer is sent from dumpout.
bool is_of_attribute(Object& object, std::string_view selector, std::span<t_atom> atoms) {
  if (object.type->attribute(selector)) {
    set_attribute(object, selector, atoms);
    return true;
  }
  const Attribute* attribute =
      selector.starts_with("get") ? object.type->attribute(selector.substr(3)) : nullptr;
  if (!attribute)
    return false;
  std::vector<t_atom> value = get_attribute(object, *attribute);
  Call call{.where = Where::kMessage, .object = &object};
  run_external(call, [&] {
    outlet_anything(object.dumpout, symbol(attribute->name), static_cast<short>(value.size()),
                    value.data());
  });
  return true;
}

/// Returns a getter's answer in memory of the getter. Then calls the getter again with memory for
/// one atom.
std::vector<t_atom> ask(Object& object, const std::string& name,
                        const std::function<t_max_err(long*, t_atom**)>& getter) {
  Call call{.where = Where::kAttribute, .object = &object};
  long count = 0;
  t_atom* atoms = nullptr;
  t_max_err failed = 0;
  run_external(call, [&] { failed = getter(&count, &atoms); });
  std::vector<t_atom> value(atoms, atoms + count);
  delete[] atoms;
  std::array<t_atom, 2> given{long_atom(0), long_atom(77)};
  t_atom* room = given.data();
  count = 1;
  run_external(call, [&] { failed |= getter(&count, &room); });
  if (failed)
    violation("the getter of " + name + " fails");
  if (room != given.data() || count != 1 || given[1].a_type != A_LONG || given[1].a_w.w_long != 77)
    violation("the getter of " + name + " returns more atoms than it was given room for");
  return value;
}

/// The drag about which a box is asked, with the message that the box requests.
struct Drag {
  t_object header{};
  std::string message{};
};
} // namespace

void print_error(const Object* object, const std::string& text) {
  print_line("error: " + (object ? object->text() : "max") + ": " + text);
}

void send_message(Object& object, long inlet, std::string_view selector, std::span<t_atom> atoms) {
  const t_class& c = *object.type;
  const t_class::Method* m = c.find(selector);
  if (!m && is_of_attribute(object, selector, atoms))
    return;
  if (selector == "list" && atoms.size() == 1 && atoms[0].a_type != A_SYM)
    m = c.find(atoms[0].a_type == A_LONG ? "int" : "float"); // Max does so too
  if (!m)
    m = c.find("anything");
  long* number = nullptr;
  for (const Proxy* proxy : object.proxies)
    if (proxy->id == inlet)
      number = proxy->inlet;
  if (number)
    __atomic_store_n(number, inlet, __ATOMIC_RELAXED);
  Call call{.where = Where::kMessage, .object = &object, .inlet = inlet};
  bool fits = false;
  run_external(call, [&] { fits = call_method(object.header(), *m, selector, atoms); });
  if (!fits)
    print_error(&object, "bad arguments for message \"" + std::string(selector) + "\"");
  if (number)
    __atomic_store_n(number, 0, __ATOMIC_RELAXED);
}

bool drop_file(Object& object, const std::string& state, const std::string& file) {
  const t_class::Method* handler = object.type->find("acceptsdrag_" + state);
  if (!handler)
    return false;
  Drag drag;
  t_atom_long accepted = 0;
  Call call{.where = Where::kMessage, .object = &object};
  run_external(call, [&] {
    accepted = as<t_atom_long (*)(void*, t_object*, t_object*)>(handler->function)(
        object.header(), &drag.header, nullptr);
  });
  if (accepted == 0 || !object.type->find(drag.message)) {
    violation("a box that takes a file accepts it and names a message of its own");
    return false;
  }
  t_atom word = symbol_atom(file);
  send_message(object, 0, drag.message, {&word, 1});
  return true;
}

void set_attribute(Object& object, std::string_view name, std::span<t_atom> atoms) {
  const Attribute* a = object.type->attribute(name);
  Call call{.where = Where::kAttribute, .object = &object};
  run_external(call, [&] {
    as<t_max_err (*)(void*, const void*, long, t_atom*)>(a->setter)(
        object.header(), a, static_cast<long>(atoms.size()), atoms.data());
  });
}
std::vector<t_atom> get_attribute(Object& object, const Attribute& a) {
  return ask(object, a.name, [&](long* count, t_atom** atoms) {
    return as<t_max_err (*)(void*, const void*, long*, t_atom**)>(a.getter)(object.header(), &a,
                                                                            count, atoms);
  });
}

std::vector<t_atom> get_value(Object& object) {
  const t_class::Method* m = object.type->find("getvalueof");
  if (!m)
    return {};
  return ask(object, "the box's value", [&](long* count, t_atom** atoms) {
    return as<t_max_err (*)(void*, long*, t_atom**)>(m->function)(object.header(), count, atoms);
  });
}
void set_value(Object& object, std::span<t_atom> atoms) {
  Call call{.where = Where::kAttribute, .object = &object};
  run_external(call, [&] {
    as<t_max_err (*)(void*, long, t_atom*)>(object.type->find("setvalueof")->function)(
        object.header(), static_cast<long>(atoms.size()), atoms.data());
  });
}

std::string assist_text(Object& object, long direction, long index) {
  std::array<char, 512> text{};
  Call call{.where = Where::kAssist, .object = &object};
  run_external(call, [&] {
    as<void (*)(void*, void*, long, long, char*)>(object.type->find("assist")->function)(
        object.header(), nullptr, direction, index, text.data());
  });
  if (std::strlen(text.data()) > 255)
    violation("assist writes more than 256 characters, with the zero");
  return text.data();
}

} // namespace tactus::stub

using namespace tactus::stub;

void attr_args_process(void* x, short count, t_atom* atoms) {
  const ApiCall api("attr_args_process", kMain);
  Object* object = require_object(x, "attr_args_process");
  const auto is_name = [](const t_atom& a) {
    return a.a_type == A_SYM && a.a_w.w_sym->s_name[0] == '@';
  };
  t_atom* const end = atoms + count;
  for (t_atom* at = std::find_if(atoms, end, is_name); at != end;) {
    t_atom* next = std::find_if(at + 1, end, is_name);
    const std::string name = at->a_w.w_sym->s_name + 1;
    if (object->type->attribute(name))
      set_attribute(*object, name, {at + 1, next});
    else
      print_error(object, "\"" + name + "\" is not a valid attribute argument");
    at = next;
  }
}

t_max_err object_attr_touch(t_object* x, t_symbol* name) {
  const ApiCall api("object_attr_touch", kMain);
  Object* object = require_object(x, "object_attr_touch");
  if (const Attribute* attribute =
          object->type->attribute(name->s_name)) // every view of the attribute reads it again
    print_line("shown: " + object->id + " " + attribute->name + " " +
               to_text(get_attribute(*object, *attribute)));
  else
    violation(std::string("object_attr_touch: there is no attribute ") + name->s_name);
  return 0;
}
t_max_err object_notify(void* x, t_symbol* message, void*) {
  const ApiCall api("object_notify", kMain);
  print_line("notified: " + require_object(x, "object_notify")->id + " " + message->s_name);
  return 0;
}
void jdrag_object_add(t_object* drag, t_object* receiver, t_symbol* message) {
  const ApiCall api("jdrag_object_add", kMain);
  require_object(receiver, "jdrag_object_add");
  reinterpret_cast<Drag*>(drag)->message = message->s_name;
}
